"""FMI 2 callbacks that collect what an FMU says."""

from fmpy.fmi2 import (
    calloc,
    fmi2CallbackAllocateMemoryTYPE,
    fmi2CallbackFreeMemoryTYPE,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
    free,
)


def collecting(messages: list[str]) -> fmi2CallbackFunctions:
    """Return FMI callbacks that append the text of every message to a list."""
    callbacks = fmi2CallbackFunctions()

    def keep(environment, instance, status, category, message):
        messages.append(message.decode())

    callbacks.logger = fmi2CallbackLoggerTYPE(keep)
    callbacks.allocateMemory = fmi2CallbackAllocateMemoryTYPE(calloc)
    callbacks.freeMemory = fmi2CallbackFreeMemoryTYPE(free)
    return callbacks

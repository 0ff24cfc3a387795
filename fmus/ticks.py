"""Instants and oscillations of sampled sources that count their ticks."""

from typing import Any

import numpy as np

WORD = 2.0**26


def tick_of(t: Any, T_s: Any) -> Any:
    """Return the first tick not before the time t (s), a millionth of one early."""
    return np.ceil(t / T_s - 1e-6)


def turn(frequency_hz: Any, k: Any, T_s: Any) -> Any:
    """Return the part of a cycle, in [0, 1), that f k T_s is past a whole one.

    The cycles per tick are split so that whole cycles cancel without rounding:
    good to 2e-16 of a cycle for every k up to 2²⁷.
    """
    cycles = frequency_hz * T_s
    coarse = np.floor(cycles * WORD) / WORD
    turns = k * coarse
    phase = (turns - np.floor(turns)) + k * (cycles - coarse)
    return phase - np.floor(phase)


def sine(frequency_hz: Any, k: Any, T_s: Any) -> Any:
    """Return sin(2π f k T_s) to 1e-15 for every k up to 2²⁷."""
    return np.sin(2 * np.pi * turn(frequency_hz, k, T_s))

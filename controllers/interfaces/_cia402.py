"""The power drive state machine of CiA 402, from the controller's side.

The status word (6041h) says the state in bits 0 to 3, 5 and 6; the control word
(6040h) asks for the next:

    not ready          x0xx 0000        wait
    switch on disabled x1xx 0000   ->   shutdown          0006h
    ready to switch on x01x 0001   ->   switch on         0007h
    switched on        x01x 0011   ->   enable operation  000Fh
    operation enabled  x01x 0111   ->   enable operation  000Fh
    quick stop active  x00x 0111   ->   disable voltage   0000h
    fault              x0xx 1xxx   ->   0000h, fault reset 0080h

Source: IEC 61800-7-201 (CiA 402), tables of control and status word.
"""

from typing import Any

import numpy as np

from controllers.interfaces._words import bit


def operation_enabled(status: Any) -> Any:
    """Return 1 if the drive follows its target, else 0."""
    low = bit(status, 0) + bit(status, 1) + bit(status, 2)
    held = low * bit(status, 5) * (1 - bit(status, 3)) * (1 - bit(status, 6))
    return np.where(held > 2.5, 1.0, 0.0)


def control_word(status: Any, enable: Any, reset: Any) -> Any:
    """Return the word that leads towards operation, or away from it.

    Without ``enable`` the drive is taken back to ready to switch on; ``reset`` sets
    the bit whose rise acknowledges a fault.
    """
    ready, on, active = bit(status, 0), bit(status, 1), bit(status, 2)
    fault, no_quick_stop, disabled = bit(status, 3), bit(status, 5), bit(status, 6)
    next_word = np.where(on > 0.5, 15.0, np.where(ready > 0.5, 7.0, 6.0))
    word = np.where(enable > 0.5, next_word, 6.0)
    word = np.where((1 - no_quick_stop) * active > 0.5, 0.0, word)
    not_ready = (1 - disabled) * (1 - ready) * (1 - fault)
    word = np.where(not_ready > 0.5, 0.0, word)
    return np.where(fault > 0.5, 128.0 * np.where(reset > 0.5, 1.0, 0.0), word)

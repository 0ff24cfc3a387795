"""Modes and lags that a drive has besides its axial mode.

q̈ + 2ζω q̇ + ω² q = f,    ẏ = ω (u - y)
"""

from typing import Any

import numpy as np


def acceleration(q: Any, v: Any, f: Any, omega_hz: Any, zeta: Any) -> Any:
    """Return q̈ of a mode at omega_hz (Hz) driven by f (unit of q per s²)."""
    omega = 2 * np.pi * omega_hz
    return f - 2 * zeta * omega * v - omega * omega * q


def lag(y: Any, u: Any, omega_hz: Any) -> Any:
    """Return ẏ of a first-order lag of bandwidth omega_hz (Hz)."""
    return 2 * np.pi * omega_hz * (u - y)

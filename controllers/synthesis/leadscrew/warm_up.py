"""How warm a mechanism has become: carried from the warm-up motion into what follows.

Source: Maeda 2007, sec. 3.3 (a sine of 20 mm at 0.6 Hz during 40 s).
"""

from fmus.model import FloatArray


def reached(w: FloatArray, T_s: float) -> dict[str, float]:
    """Return the warmth at the end of a run as a start value: a design step.

    Args:
        w: warmth of ``plants.leadscrew.warming``, (n,).
        T_s: sample time (s), not needed.
    """
    return {"state.warmth": float(w[-1])}

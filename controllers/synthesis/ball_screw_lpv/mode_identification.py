"""The flexible mode from frequency responses, over the stroke, and back to M, K, C.

At one position, with H_i = G_i1 - G_rigid for i = 1, 2 and G_22 of rank one,

    H_i (ω² + jw c) - α_i1 - jw β_i1 = w² H_i,    c = 2ζω shared
    α_22 + jω β_22 = (α_21 + jω β_21)²/(α_11 + jω β_11)

is linear in the unknowns; rows are weighted by the denominator found before.  Over
positions each parameter is fitted by c_0 + c_1 x + c_2 x² + c_3 sin(x/r_g + c_4).
The matrices behind rigid body and mode follow from (3.12): one mode of a two-mass
drive has φ φ' = α/1, M = (rigid + mode)⁻¹ at infinite frequency, K = M Φ Ω² Φ' M.

Source: Hanifzadegan 2014, sec. 3.4.2, 3.5, eq. 3.12, 3.24 to 3.27, fig. 3.16.
"""

from typing import NamedTuple

import numpy as np

from controllers.synthesis.lpv.systems import ComplexArray, Matrix
from plants.ball_screw_lpv._drive import Amplifier
from plants.ball_screw_lpv._mode import R_G, Mode, Rigid, inertia

PASSES = 10  # of the weighting: it settles in three


class Fit(NamedTuple):
    """c_0 ... c_3 and the phase c_4 (rad)."""

    c: Matrix
    phase: float

    def at(self, x: Matrix, r_g: float = R_G) -> Matrix:
        """Return the function at positions x (m)."""
        smooth = self.c[0] + x * (self.c[1] + x * self.c[2])
        return np.asarray(smooth + self.c[3] * np.sin(x / r_g + self.phase))


class Plane(NamedTuple):
    """A value at x_c = 0 without workpiece, its slopes, and the error of the fit."""

    c_0: float
    c_x: float
    c_m: float
    mean: float
    rms: float


class Physical(NamedTuple):
    """M (kg), C (kg/s), K (N/m) of the two ends, each (2, 2)."""

    M: Matrix
    C: Matrix
    K: Matrix


def flexible_mode(
    omega: Matrix,
    G: ComplexArray,
    m_wor: float = 0.0,
    rigid: Rigid | None = None,
) -> Mode:
    """Return the mode that explains responses from the motor's force.

    Args:
        omega: frequencies, shape (n,) (rad/s).
        G: f_m → (u_m, u_c), shape (n, 2) (m/N).
        m_wor: workpiece (kg), part of the rigid body.
        rigid: the rigid body; Table 3.2 if None.

    Raises:
        ValueError: the shapes do not fit, or no stable mode explains the responses.
    """
    if G.shape != (len(omega), 2):
        raise ValueError(f"G is of shape {G.shape}, not {(len(omega), 2)}")
    p = Rigid() if rigid is None else rigid
    s = 1j * np.asarray(omega)
    body = p.r_g**2 / (s * (inertia(m_wor, p) * s + p.B_e))
    H = G - body[:, None]
    weight = np.ones(len(s))
    found: Matrix = np.zeros(6)
    for _ in range(PASSES):
        found = _solved(s, H, weight)
        weight = 1 / np.abs(s * s + found[1] * s + found[0])
    stiffness, damping = found[:2]
    if stiffness <= 0 or damping <= 0:
        raise ValueError("no stable mode explains the responses")
    frequency = np.sqrt(stiffness)
    alpha_11, beta_11, alpha_12, beta_12 = map(float, found[2:])
    zeta = float(damping / (2 * frequency))
    return Mode(zeta, float(frequency), alpha_11, alpha_12, beta_11, beta_12)


def responses(f_hz: Matrix, T_s: float, u: Matrix, y: Matrix) -> ComplexArray:
    """Return the responses to one held, periodic input, shape (n, outputs).

    Args:
        f_hz: excited lines, each with whole periods in the record, shape (n,) (Hz).
        T_s: sample time (s).
        u: input held from each sample on, shape (m,).
        y: outputs at the samples, shape (m, outputs).

    Raises:
        ValueError: a line does not complete whole periods.
    """
    lines = np.asarray(f_hz) * (len(u) * T_s)
    at = np.rint(lines).astype(int)
    if np.max(np.abs(lines - at)) > 1e-6:
        raise ValueError(
            f"the record of {len(u) * T_s:g} s does not hold whole periods of each line"
        )
    delay = 2j * np.pi * np.asarray(f_hz) * T_s
    hold = -np.expm1(-delay) / delay
    U, Y = np.fft.rfft(u)[at], np.fft.rfft(y, axis=0)[at]
    return np.asarray(Y / (U * hold)[:, None])


def stroke(
    T_s: float,
    x_c: Matrix,
    v_m: Matrix,
    u_m: Matrix,
    u_c: Matrix,
    f_0_hz: float = 110.0,
    spacing_hz: float = 10 / 3,
    lines: int = 91,
    k_t: float = Amplifier().k_t,
    k_a: float = Amplifier().k_a,
) -> dict[str, Matrix]:
    """Return Table 3.3 from one run that stays at many positions (``stations``).

    The last period of the multisine at each position is taken.

    Args:
        T_s: sample time of the signals (s).
        x_c, v_m, u_m, u_c: positions (m), command (V), both ends (m), shape (n,).
        f_0_hz, spacing_hz, lines: of the multisine (``plants.disturbances``).
        k_t, k_a: torque constant and current per command.

    Returns:
        ``mode.zeta`` and so forth, coefficients (4,), and ``mode.phase`` (6,), as the
        parameters of ``plants.ball_screw_lpv.lpv``.

    Raises:
        ValueError: fewer than five positions, or no mode explains one.
    """
    n = round(1 / (spacing_hz * T_s))
    f_hz = f_0_hz + spacing_hz * np.arange(lines)
    ends = [*(np.flatnonzero(np.diff(x_c) != 0) + 1), len(x_c) - 1]
    if len(ends) < 5:
        raise ValueError(f"{len(ends)} positions do not determine five coefficients")
    force = k_t * k_a / R_G * np.asarray(v_m)
    y = np.column_stack([u_m, u_c])
    modes = [
        flexible_mode(
            2 * np.pi * f_hz,
            responses(f_hz, T_s, force[end - n : end], y[end - n : end]),
        )
        for end in ends
    ]
    x = np.array([x_c[end - 1] for end in ends])
    fits = [over_stroke(x, np.array(values)) for values in zip(*modes, strict=True)]
    found = {
        f"mode.{name}": fit.c for name, fit in zip(Mode._fields, fits, strict=True)
    }
    return found | {"mode.phase": np.array([fit.phase for fit in fits])}


def rank_one(mode: Mode) -> tuple[float, float]:
    """Return α_22 and β_22 (eq. 3.26)."""
    s = 1j * mode.omega
    own, cross = mode.alpha_11 + s * mode.beta_11, mode.alpha_12 + s * mode.beta_12
    table = cross * cross / own
    return float(table.real), float(table.imag / mode.omega)


def over_stroke(x: Matrix, values: Matrix, r_g: float = R_G) -> Fit:
    """Return the fit of (3.27) to values at positions x, both (n,)."""
    x = np.asarray(x, dtype=float)
    columns = [np.ones_like(x), x, x * x, np.sin(x / r_g), np.cos(x / r_g)]
    found = np.linalg.lstsq(np.column_stack(columns), values, rcond=None)[0]
    amplitude, phase = np.hypot(*found[3:]), np.arctan2(found[4], found[3])
    return Fit(np.array([*found[:3], amplitude]), float(phase))


def over_position_and_mass(x: Matrix, m_wor: Matrix, values: Matrix) -> Plane:
    """Return the affine fit over position (m) and mass (kg), all (n,) (sec. 3.5.2)."""
    A = np.column_stack([np.ones(len(x)), x, m_wor])
    found = np.linalg.lstsq(A, values, rcond=None)[0]
    error = values - A @ found
    mean, rms = np.mean(np.abs(error)), np.sqrt(np.mean(error**2))
    return Plane(*map(float, (*found, mean, rms)))


def physical(mode: Mode, m_wor: float = 0.0, rigid: Rigid | None = None) -> Physical:
    """Return M, C, K of two ends that have this rigid body and this mode.

    Φ holds (1, 1)/√m and the real mode shape; with it M = Φ⁻ᵀΦ⁻¹ and so forth.
    β, by which the mode is not quite real, is left out.
    """
    p = Rigid() if rigid is None else rigid
    mass = inertia(m_wor, p) / p.r_g**2
    first = np.sqrt(mode.alpha_11)
    shapes = np.array(
        [[1 / np.sqrt(mass), first], [1 / np.sqrt(mass), mode.alpha_12 / first]]
    )
    inverse = np.linalg.inv(shapes)
    damping = np.diag([p.B_e / inertia(m_wor, p), 2 * mode.zeta * mode.omega])
    return Physical(
        inverse.T @ inverse,
        inverse.T @ damping @ inverse,
        inverse.T @ np.diag([0.0, mode.omega**2]) @ inverse,
    )


def _solved(s: ComplexArray, H: ComplexArray, weight: Matrix) -> Matrix:
    """Return ω², c, α_11, β_11, α_21, β_21 of the weighted linear equations."""
    zero, one = np.zeros_like(s), np.ones_like(s)
    rows = [
        np.column_stack([H[:, 0], s * H[:, 0], -one, -s, zero, zero]),
        np.column_stack([H[:, 1], s * H[:, 1], zero, zero, -one, -s]),
    ]
    A = np.concatenate(rows) * np.tile(weight, 2)[:, None]
    b = np.concatenate([-s * s * H[:, 0], -s * s * H[:, 1]]) * np.tile(weight, 2)
    A, b = np.concatenate([A.real, A.imag]), np.concatenate([b.real, b.imag])
    scale = np.linalg.norm(A, axis=0)
    return np.asarray(np.linalg.lstsq(A / scale, b, rcond=None)[0] / scale)

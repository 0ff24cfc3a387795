"""The controller behind X and Y at one point, by explicit formulas, D_K = 0.

    [0 D_21 0; D_21' -γI D_11'; 0 D_11 -γI] [B̂'; *] = -[C_2; B_1'X; C_1]
    [0 D_12' 0; D_12 -γI D_11; 0 D_11' -γI] [Ĉ; *]  = -[B_2'; C_1 Y; B_1']
    Â = -A' + [XB_1 + B̂D_21, C_1'] [-γI D_11'; D_11 -γI]⁻¹ [B_1'; C_1 Y + D_12 Ĉ]
    A_K = X⁻¹ (Â - XAY - B̂C_2 Y - XB_2 Ĉ)(X⁻¹ - Y)⁻¹,  B_K = X⁻¹ B̂,  C_K = Ĉ (X⁻¹ - Y)⁻¹

X being constant, no rate of a parameter enters, and the states of all points are
the same: tables of these matrices may be interpolated.

Source: Gahinet 1996; Hanifzadegan 2014, eq. 4.11, 4.12 with D_K = 0.
"""

import numpy as np

from controllers.synthesis.lpv.systems import GeneralisedPlant, Matrix, System


def controller(plant: GeneralisedPlant, X: Matrix, Y: Matrix, gamma: float) -> System:
    """Return K of order n for X, Y that fulfil their inequalities at gamma.

    Raises:
        ValueError: D_11 is not below gamma, no controller without D_K exists.
    """
    D_11, D_12, D_21 = plant.D_11, plant.D_12, plant.D_21
    if np.linalg.norm(D_11, 2) >= gamma:
        raise ValueError(f"D_11 alone has a gain of gamma = {gamma:g} or more")
    XB_1, C_1Y = X @ plant.B_1, plant.C_1 @ Y
    B_hat = _implied(D_21, D_11.T, gamma, [plant.C_2, XB_1.T, plant.C_1]).T
    C_hat = _implied(D_12.T, D_11, gamma, [plant.B_2.T, C_1Y, plant.B_1.T])
    (p, m), eye = D_11.shape, np.eye
    gains = np.block([[-gamma * eye(m), D_11.T], [D_11, -gamma * eye(p)]])
    left = np.hstack([XB_1 + B_hat @ D_21, plant.C_1.T])
    right = np.vstack([plant.B_1.T, C_1Y + D_12 @ C_hat])
    A_hat = -plant.A.T + left @ np.linalg.solve(gains, right)
    known = X @ plant.A @ Y + B_hat @ plant.C_2 @ Y + X @ plant.B_2 @ C_hat
    gap = np.linalg.inv(X) - Y
    inner = np.linalg.solve(X, np.hstack([A_hat - known, B_hat]))
    n = len(X)
    return System(
        np.linalg.solve(gap.T, inner[:, :n].T).T,
        inner[:, n:],
        np.linalg.solve(gap.T, C_hat.T).T,
        np.zeros((D_12.shape[1], D_21.shape[0])),
    )


def _implied(D: Matrix, D_11: Matrix, gamma: float, rows: list[Matrix]) -> Matrix:
    """Solve [0 D 0; D' -γI D_11; 0 D_11' -γI] [wanted; *] = -rows for ``wanted``."""
    k, a, b = len(D), D.shape[1], D_11.shape[1]
    left = np.block(
        [
            [np.zeros((k, k)), D, np.zeros((k, b))],
            [D.T, -gamma * np.eye(a), D_11],
            [np.zeros((b, k)), D_11.T, -gamma * np.eye(b)],
        ]
    )
    return np.asarray(np.linalg.solve(left, -np.vstack(rows)))[:k]

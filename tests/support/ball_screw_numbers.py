"""The drive and the gains of the ball-screw study (Gordon 2010), for its tests."""

T_S = 5e-5
M_1, M_2, B_1, B_2, K, C = 1.858e-3, 0.379e-3, 1.020e-3, 0.0, 210.02, 0.014
K_X1, K_X2, K_V1, K_V2, K_I2 = (
    632.9653,
    -83.312458,
    1.648469979,
    0.264903101,
    70135.3877,
)
SET_A = {"K_px": 189.0, "K_pv": 0.91, "K_iv": 119.0}
SET_B = {"K_px": 329.0, "K_pv": 0.668, "K_iv": 2.39}

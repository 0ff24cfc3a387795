"""The command is exact to the last digits, whatever the move."""

from fractions import Fraction
from itertools import product
from math import ceil, lcm

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from controllers.ball_screw import model_inversion
from controllers.references.trajectory import (
    Input,
    Output,
    Parameters,
    State,
    move_time,
    prepare,
    step,
)

T_s = 1 / 20_000


def command(p: Parameters, k: np.ndarray) -> Output:
    """Our command at the ticks k, all at once: the equations are elementwise."""
    _, y = step(State(k.astype(float)), Input(), p, T_s, prepare(p, T_s))
    return Output(*(np.broadcast_to(signal, k.shape) for signal in y))


class Exact:
    """The same command in rational numbers, from the closed form of the source."""

    def __init__(self, p: Parameters) -> None:
        D, V, A, J, S, r_g = map(
            Fraction, (p.stroke, p.v_max, p.a_max, p.j_max, p.s_max, p.r_g)
        )
        T = [abs(D) / V, V / A, A / J, J / S]
        # one denominator for all times, so that a tick costs integers only
        times = [Fraction(T_s), Fraction(p.t_0), Fraction(p.dwell), *T]
        self.unit = lcm(*(t.denominator for t in times))
        self.scale = (1 if D >= 0 else -1) * S / r_g
        self.stroke = D / r_g
        self.tick, self.t_0, self.dwell, *T_i = (int(t * self.unit) for t in times)
        self.move = sum(T_i)
        self.switches = [
            (sum(t for t, used in zip(T_i, m, strict=True) if used), (-1) ** sum(m))
            for m in product((0, 1), repeat=4)
        ]
        self.back = p.back

    def at(self, k: int, order: int = 0) -> Fraction:
        """Return a derivative of the command at t = k T_s."""
        t = int(k) * self.tick - self.t_0
        t_back = self.move + self.dwell
        if self.back and t >= t_back:
            done = self._single(t - t_back, order)
            return self.stroke - done if order == 0 else -done
        return self._single(t, order)

    def _single(self, t: int, order: int) -> Fraction:
        n = 4 - order
        total = sum(s * (t - tau) ** n for tau, s in self.switches if t >= tau)
        return self.scale * Fraction(total, [24, 6, 2, 1, 1][order] * self.unit**n)


def last_tick(p: Parameters) -> int:
    return ceil(((1 + p.back) * move_time(p) + p.t_0 + p.back * p.dwell) / T_s) + 3


@pytest.mark.parametrize("v_max", [0.2, 0.5, 1.0])
def test_every_tick_of_the_studys_moves_is_the_double_nearest_to_exact(
    v_max: float,
) -> None:
    p = Parameters(v_max=v_max)
    k = np.arange(last_tick(p))
    reference = Exact(p)
    exact = np.array([float(reference.at(int(i))) for i in k])
    assert np.array_equal(command(p, k).x_r, exact)


def moves() -> st.SearchStrategy[Parameters]:
    def between(low: float, high: float) -> st.SearchStrategy[float]:
        return st.floats(np.log10(low), np.log10(high)).map(lambda x: 10.0**x)

    return st.builds(
        Parameters,
        stroke=st.one_of(
            st.sampled_from([0.0, 5e-6, -5e-6, 0.25, -0.3]),
            between(1e-7, 2.0),
            between(1e-7, 2.0).map(lambda x: -x),
        ),
        v_max=between(1e-2, 3),
        a_max=between(0.5, 50),
        j_max=between(50, 1e4),
        s_max=between(5e3, 1e6),
        t_0=st.sampled_from([0.0, 0.020, 0.0123]),
        back=st.booleans(),
        dwell=st.sampled_from([0.0, 0.04]),
        r_g=st.just(Parameters().r_g),
    )


def rounding(p: Parameters) -> float:
    """What 15 shifts of the segments in doubled digits leave at the move's end (rad).

    A jerk that should be nothing is rounded at 2^-104 of its limit, and so on, and
    acts until the end.  It is seen where a long return comes back to zero.
    """
    T = move_time(p)
    reached = p.v_max * T + p.a_max * T**2 / 2 + p.j_max * T**3 / 6
    return 15 * 2.0**-104 * reached / p.r_g


@given(p=moves(), part=st.lists(st.floats(0, 1), min_size=5, max_size=20))
@example(
    p=Parameters(
        v_max=0.01, a_max=1.0, j_max=100.0, s_max=1e4, t_0=0, back=True, dwell=0
    ),
    part=[0.99999],
)
def test_any_move_is_exact(p: Parameters, part: list[float]) -> None:
    k = np.unique(np.round(np.array(part) * last_tick(p)))
    exact, ours = Exact(p), command(p, k)
    x_r = np.array([float(exact.at(int(i))) for i in k])
    assert np.all(np.abs(ours.x_r - x_r) <= np.spacing(np.abs(x_r)) + rounding(p))
    ceilings = np.array([p.v_max, p.a_max, p.j_max, 2 * p.s_max]) / p.r_g
    for order in range(1, 5):
        derivative = np.array([float(exact.at(int(i), order)) for i in k])
        error = np.max(np.abs(ours[order] - derivative))
        assert error <= 8 * np.spacing(ceilings[order - 1]), f"derivative {order}"


@given(p=moves())
def test_a_move_ends_exactly_on_its_stroke_and_at_rest(p: Parameters) -> None:
    end = command(p, np.array([last_tick(p), last_tick(p) + 10**6]))
    goal = 0.0 if p.back else p.stroke / p.r_g
    for signal, value in zip(end, (goal, 0, 0, 0, 0), strict=True):
        assert np.all(signal == value)


def test_velocity_acceleration_and_jerk_stay_within_their_limits() -> None:
    for v_max in (0.2, 0.5, 1.0):
        p = Parameters(v_max=v_max)
        y = command(p, np.arange(last_tick(p)))
        assert np.max(np.abs(y.v_r)) * p.r_g <= p.v_max * (1 + 1e-14)
        assert np.max(np.abs(y.a_r)) * p.r_g <= p.a_max * (1 + 1e-14)
        assert np.max(np.abs(y.j_r)) * p.r_g <= p.j_max * (1 + 1e-14)


def test_snap_is_a_train_of_steps_of_its_limit_where_stages_do_not_overlap() -> None:
    p = Parameters(v_max=1.0)
    s_r = command(p, np.arange(last_tick(p))).s_r
    assert set(np.unique(s_r)) == {-p.s_max / p.r_g, 0.0, p.s_max / p.r_g}


def test_peak_acceleration_at_200_mm_s_is_that_of_overlapping_stages() -> None:
    p = Parameters(v_max=0.2)
    a_r = command(p, np.arange(last_tick(p))).a_r * p.r_g
    assert np.max(a_r) == pytest.approx(8.7445, abs=1e-4)


@pytest.mark.parametrize(
    ("v_max", "expected"), [(0.2, 1.30001), (0.5, 0.58059), (1.0, 0.38156)]
)
def test_move_times_are_those_of_the_study(v_max: float, expected: float) -> None:
    assert move_time(Parameters(v_max=v_max)) == pytest.approx(expected, abs=5e-6)


def test_one_tick_at_a_time_gives_what_all_ticks_at_once_give() -> None:
    p = Parameters(back=True, v_max=1.0, stroke=0.04)
    d = prepare(p, T_s)
    for k in range(0, last_tick(p), 97):
        x, y = step(State(float(k)), Input(), p, T_s, d)
        assert x.k == k + 1
        assert tuple(map(float, y)) == tuple(s[0] for s in command(p, np.array([k])))


def feedforward(x_r: np.ndarray) -> np.ndarray:
    """Run the model inversion, in the precision of its input."""
    p, x = model_inversion.Parameters(), model_inversion.State()
    d = model_inversion.prepare(p, T_s)
    u_ff = np.zeros_like(x_r)
    for k, command_k in enumerate(x_r):
        u = model_inversion.Input(command_k)
        x, y = model_inversion.step(x, u, p, T_s, d)
        u_ff[k] = y.u_ff
    return u_ff


def test_command_keeps_the_feedforward_within_a_millivolt_of_the_exact_one() -> None:
    p = Parameters(v_max=0.5)
    k = np.arange(last_tick(p) + 200)
    exact = Exact(p)
    x_r = np.array([_extended(exact.at(int(i))) for i in k])
    u_ff = feedforward(x_r)
    ours = feedforward(command(p, k).x_r)
    plain = feedforward(power_sum(p, k * T_s))
    assert np.max(np.abs(ours - u_ff)) < 1e-3
    assert np.max(np.abs(plain - u_ff)) > 4.6e-2


def _extended(value: Fraction) -> np.longdouble:
    high = float(value)
    return np.longdouble(high) + np.longdouble(float(value - Fraction(high)))


def power_sum(p: Parameters, t: np.ndarray) -> np.ndarray:
    """The closed form as one would write it down, in doubles."""
    T = (p.stroke / p.v_max, p.v_max / p.a_max, p.a_max / p.j_max, p.j_max / p.s_max)
    x_r = np.zeros_like(t)
    for m in product((0, 1), repeat=4):
        late = np.maximum(t - p.t_0 - np.dot(m, T), 0.0)
        x_r = x_r + (-1) ** sum(m) * p.s_max / p.r_g * late**4 / 24
    return x_r

"""A whole controller is its parts wired at one instant, nothing more."""

import numpy as np
import pytest

from controllers.ball_screw import (
    filter_pack,
    friction_feedforward,
    inertia_feedforward,
    mc_ppc,
    model_inversion,
    p_pi,
    position_p,
    rotary_command,
    state_feedback,
    velocity_pi,
)
from controllers.filters import prefilter
from controllers.synthesis.parameters import with_values
from fmus.model import Model, Record, Sampled, leaves, pack, unpack

T_s = 1 / 20_000


class Part:
    """One model on its own, its parameters taken by name from a composite's."""

    def __init__(self, model: Model, **values: float) -> None:
        assert isinstance(model, Sampled)
        names = [leaf.name for leaf in leaves(model.parameters)]
        missing = set(names) - set(values)
        assert not missing, f"{model.name}: {missing}"
        self.model, self.x = model, model.state
        self.p = with_values(model.parameters, {n: values[n] for n in names})
        self.d = (model.prepare(self.p, T_s),) if model.prepare else ()

    def __call__(self, **inputs: float) -> Record:
        u = self.model.input._replace(**inputs)
        self.x, y = self.model.step(self.x, u, self.p, T_s, *self.d)
        return y


def unlike_the_defaults(parameters: Record) -> Record:
    """Every number of its own, so that no two can be mixed up unnoticed."""
    values = pack(parameters)
    rng = np.random.default_rng(17)
    for i, leaf in enumerate(leaves(parameters)):
        if leaf.boolean:
            values[i] = True
        else:
            values[i] = (values[i] or 1e-8) * rng.uniform(0.7, 1.3)
    return unpack(parameters, values)


def signals() -> list[dict[str, float]]:
    rng = np.random.default_rng(23)
    names = mc_ppc.Input._fields
    return [dict(zip(names, rng.normal(size=8), strict=True)) for _ in range(50)]


@pytest.mark.parametrize("analytic", [False, True])
def test_mc_ppc_is_its_parts(analytic: bool) -> None:
    p = unlike_the_defaults(mc_ppc.Parameters())._replace(analytic=analytic)
    shared = {leaf.name: leaf.value for leaf in leaves(p)}
    pre = Part(prefilter.model, **shared)
    rotary = Part(rotary_command.model, **shared, on=p.rotary.on)
    inversion = Part(model_inversion.model, **shared, on=p.inversion.on)
    feedback = Part(state_feedback.model, **shared)
    filters = Part(filter_pack.model, **p.filters._asdict())
    friction = Part(friction_feedforward.model, **p.friction._asdict())
    whole = Part(mc_ppc.model, **shared)
    for s in signals():
        r = {name: s[name] for name in ("v_r", "a_r", "j_r", "s_r")}
        x_f = pre(x_r=s["x_r"]).x_f
        x_1r = rotary(x_r=x_f, v_r=s["v_r"], a_r=s["a_r"]).x_1r
        u_ff = inversion(x_r=x_f, **r).u_ff
        v = feedback(x_1r=x_1r, x_2r=x_f, y_1=s["y_1"], y_2=s["y_2"]).v
        u_f = friction(v_r=s["v_r"]).u_f + s["u_d"]
        assert whole(**s) == (filters(v=v, u_ff=u_ff, u_f=u_f).u, u_ff, x_f)


def test_p_pi_is_its_parts() -> None:
    p = unlike_the_defaults(p_pi.Parameters())
    shared = {leaf.name: leaf.value for leaf in leaves(p)}
    pre = Part(prefilter.model, **shared)
    position, velocity = (
        Part(position_p.model, **shared),
        Part(velocity_pi.model, **shared),
    )
    inversion = Part(inertia_feedforward.model, **shared, on=p.inversion.on)
    filters = Part(filter_pack.model, **p.filters._asdict())
    friction = Part(friction_feedforward.model, **p.friction._asdict())
    whole = Part(p_pi.model, **shared)
    for s in signals():
        x_f = pre(x_r=s["x_r"]).x_f
        v_c = position(x_r=x_f, y_2=s["y_2"]).v_c
        v = velocity(v_c=v_c, x_r=x_f, y_1=s["y_1"]).v
        u_ff = inversion(x_r=x_f).u_ff
        u_f = friction(v_r=s["v_r"]).u_f + s["u_d"]
        assert whole(**s) == (filters(v=v, u_ff=u_ff, u_f=u_f).u, u_ff, x_f)


def test_whole_controllers_can_take_each_others_place() -> None:
    assert mc_ppc.model.input._fields == p_pi.model.input._fields
    assert mc_ppc.Output is p_pi.Output

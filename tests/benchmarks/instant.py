"""One instant of the drive as one CasADi function, for peers that map over members.

Composed of our traced models in the order of the master: the plant's five substeps,
the trajectory, the encoder, the controller, whose output is published one sample late.
"""

import importlib
from dataclasses import dataclass
from fractions import Fraction

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from fmus.model import leaves, pack
from fmus.trace import numpy_on_symbols, trace
from orchestrator.system import System

MODULES = {
    "trajectory": "controllers.references.trajectory",
    "controller": "controllers.ball_screw.mc_ppc",
    "plant": "plants.ball_screw.two_mass",
    "encoder": "plants.ball_screw.encoder",
}
ROWS = ("trajectory.x_r", "encoder.y_2", "controller.u", "plant.x_2")
T, SUBSTEPS = Fraction(1, 20_000), 5
PYTHON = {
    "ADD": "{}+{}", "SUB": "{}-{}", "MUL": "{}*{}", "DIV": "{}/{}", "NEG": "-{}",
    "SQ": "{0}*{0}", "TWICE": "2.*{}", "FABS": "jnp.abs({})", "SIGN": "jnp.sign({})",
    "NOT": "f({}==0)", "SQRT": "jnp.sqrt({})", "INV": "1./{}", "EXP": "jnp.exp({})",
    "TANH": "jnp.tanh({})", "FLOOR": "jnp.floor({})", "CEIL": "jnp.ceil({})",
    "ASSIGN": "{}", "FMIN": "jnp.minimum({},{})", "FMAX": "jnp.maximum({},{})",
    "LT": "f({}<{})", "LE": "f({}<={})", "EQ": "f({}=={})", "NE": "f({}!={})",
    "AND": "f(({}!=0)&({}!=0))", "OR": "f(({}!=0)|({}!=0))",
    "IF_ELSE_ZERO": "jnp.where({}!=0,{},0.)",
}  # fmt: skip
Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Instant:
    """``function(x, p, d) -> (x at the next instant, row)`` and where it begins."""

    function: ca.Function
    x: Vector
    p: Vector
    at: int  # of the mass in p
    prepare: ca.Function
    rows: int = len(ROWS)

    @property
    def mass(self) -> float:
        return float(self.p[self.at])

    def row(self, signal: str) -> int:
        return ROWS.index(signal)

    def parameters(self, masses: list[float]) -> tuple[Vector, Vector]:
        """Return parameters and what is derived of them, (members, n) each."""
        p = np.tile(self.p, (len(masses), 1))
        p[:, self.at] = masses
        d = np.array([np.ravel(self.prepare(one)) for one in p])
        return np.ascontiguousarray(p), np.ascontiguousarray(d.reshape(len(masses), -1))

    def python(self) -> str:
        """Return the same operations as a function of jax.numpy, on scalars."""
        names = {getattr(ca, n): n[3:] for n in dir(ca) if n.startswith("OP_")}
        f, lines = self.function, ["def instant(x, p, d):", "  into = (x, p, d)"]
        lines.append("  out = ({}, {})")
        for k in range(f.n_instructions()):
            op = names[f.instruction_id(k)]
            i, o = f.instruction_input(k), f.instruction_output(k)
            if op == "OUTPUT":
                lines.append(f"  out[{o[0]}][{o[1]}] = w{i[0]}")
                continue
            if op == "CONST":
                value = repr(float(f.instruction_constant(k)))
            elif op == "INPUT":
                value = f"into[{i[0]}][{i[1]}]"
            else:
                value = PYTHON[op].format(*(f"w{j}" for j in i))
            lines.append(f"  w{o[0]} = {value}")
        lines.append(
            "  return [jnp.stack([f(o[i]) for i in range(len(o))]) for o in out]"
        )
        return "\n".join(lines)


def instant(system: System) -> Instant:
    """Return an instant of the drive with the parameters of a system."""
    models = {n: importlib.import_module(m).model for n, m in MODULES.items()}
    traced = {n: trace(m) for n, m in models.items()}

    def named(record: object) -> list[str]:
        return [leaf.name for leaf in leaves(record)]

    with numpy_on_symbols():
        X = {n: ca.SX.sym(f"x_{n}", pack(m.state).size) for n, m in models.items()}
        P = {n: ca.SX.sym(f"p_{n}", pack(m.parameters).size) for n, m in models.items()}
        D = {n: ca.SX.sym(f"d_{n}", traced[n].derived_size) for n in models}
        held = ca.SX.sym("held")

        def outputs(n: str, y: ca.SX) -> dict[str, ca.SX]:
            return dict(
                zip(traced[n].output_like._fields, ca.vertsplit(y), strict=True)
            )

        f, h = traced["plant"].functions, float(T) / SUBSTEPS
        x, p, d = X["plant"], P["plant"], D["plant"]
        u = ca.vertcat(held, 0, 0)
        for _ in range(SUBSTEPS):
            k1 = f["derivative"](x, u, p, d)
            k2 = f["derivative"](x + h / 2 * k1, u, p, d)
            k3 = f["derivative"](x + h / 2 * k2, u, p, d)
            k4 = f["derivative"](x + h * k3, u, p, d)
            x = x + h / 6 * k1 + h / 3 * k2 + h / 3 * k3 + h / 6 * k4
        plant = outputs("plant", f["output"](x, u, p, d))

        def step(n: str, into: dict[str, ca.SX]) -> tuple[ca.SX, dict[str, ca.SX]]:
            u = ca.vertcat(
                ca.SX(0, 1), *(into.get(i, 0) for i in named(models[n].input))
            )
            after, y = traced[n].functions["step"](X[n], u, P[n], D[n], float(T))
            return after, outputs(n, y)

        x_t, trajectory = step("trajectory", {})
        x_e, encoder = step("encoder", plant)
        x_c, controller = step("controller", {**trajectory, **encoder})
        before = ca.vertcat(*X.values(), held)
        after = ca.vertcat(x_t, x_c, x, x_e, controller["u"])
        row = ca.vertcat(trajectory["x_r"], encoder["y_2"], held, plant["x_2"])
        whole = [ca.vertcat(*P.values()), ca.vertcat(*D.values())]
        fused = ca.Function("instant", [before, *whole], ca.cse([after, row]))
        derived = [
            traced[n].functions["prepare"](P[n], float(T)) if D[n].numel() else D[n]
            for n in models
        ]
        prepare = ca.Function("prepare", [whole[0]], [ca.vertcat(*derived)])
    values = {n: pack(m.parameters) for n, m in models.items()}
    for n, m in models.items():
        places = named(m.parameters)
        for key, value in system.components[n].parameters.items():
            values[n][places.index(key)] = float(value)  # type: ignore[arg-type]
    first = sum(values[n].size for n in ("trajectory", "controller"))
    return Instant(
        fused,
        np.concatenate([*(pack(m.state) for m in models.values()), [0.0]]),
        np.concatenate(list(values.values())),
        first + named(models["plant"].parameters).index("m_2"),
        prepare,
    )

"""What tests of packages have in common: parts of one stub FMU, a step, values."""

from pathlib import Path

from packages import annotated, connectors
from stub import Stub

from orchestrator.exchange.ssp.load import load_package
from orchestrator.session import run

OSP = "com.opensimulationplatform"
STEP = annotated(
    OSP,
    '<osp:Algorithm xmlns:osp="x"><osp:FixedStepAlgorithm baseStepSize="1e-3"/>'
    "</osp:Algorithm>",
)
PLAIN = {"u": Stub("input"), "k": Stub("parameter"), "y": Stub("output")}
KINDS = connectors(u="input", k="parameter", y="output")


def values(file: Path, folder: Path, *names: str, sets: tuple[str, ...] = ()) -> list:
    """Return the last recorded values of outputs."""
    done = run(load_package(file, sets), folder, report=False)
    return [float(done[name].values[-1]) for name in names]


def elements(*text: str) -> str:
    return f"<ssd:Elements>{''.join(text)}</ssd:Elements>"

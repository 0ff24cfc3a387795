"""What a component makes of its FMU: sizes of its arrays, and by which interface.

Sizes are structural parameters of FMI 3.0, set in configuration mode.
"""

from dataclasses import replace
from fractions import Fraction

from lxml import etree

from orchestrator.errors import WiringError
from orchestrator.fmu.archive import read_member
from orchestrator.fmu.declared import MOST_NUMBERS
from orchestrator.fmu.description import FmuDescription, FmuVariable
from orchestrator.system import Component


def is_structural(variable: FmuVariable) -> bool:
    return variable.causality == "structuralParameter"


def sized(fmu: FmuDescription, component: Component) -> FmuDescription:
    """Return an FMU by the interface, and with arrays of the sizes, that are said.

    Raises:
        WiringError: it has no such interface, or a size is no whole number of at
            least 1.
    """
    fmu = _by_interface(fmu, component)
    sizes = {}
    for name, value in component.values.items():
        theirs = component.map[name].name if name in component.map else name
        variable = fmu.variables.get(theirs)
        if variable is None or not is_structural(variable):
            continue
        if isinstance(value, str | bool | tuple) or value != value // 1 or value < 1:
            raise WiringError(
                f"components.{component.name}.parameters.{name} = {value!r}: the size "
                f"of an array is a whole number of at least 1"
            )
        sizes[str(variable.reference)] = int(Fraction(value))
    if not sizes:
        return fmu
    resized = {name: _resized(v, sizes) for name, v in fmu.variables.items()}
    total = sum(v.size for v in resized.values())
    if total > MOST_NUMBERS:
        raise WiringError(
            f"components.{component.name}: its arrays would be {total} numbers; at "
            f"most {MOST_NUMBERS} are accepted"
        )
    return replace(fmu, variables=resized)


def _by_interface(fmu: FmuDescription, component: Component) -> FmuDescription:
    if component.interface is None:
        return fmu
    has = {"co_simulation": fmu.co_simulation, "model_exchange": fmu.model_exchange}
    if not has[component.interface]:
        raise WiringError(
            f"components.{component.name}.interface = {component.interface!r}: "
            f"{fmu.path.name} has {' and '.join(k for k, v in has.items() if v)} only"
        )
    if component.interface == "co_simulation" or not fmu.co_simulation:
        return fmu
    root = etree.fromstring(read_member(fmu.path, "modelDescription.xml"))
    told = root.find("ModelExchange")
    assert told is not None
    return replace(
        fmu,
        co_simulation=False,
        clock=None,
        model_identifier=told.get("modelIdentifier", ""),
        needs_execution_tool=told.get("needsExecutionTool") in ("true", "1"),
        once_per_process=told.get("canBeInstantiatedOnlyOncePerProcess")
        in ("true", "1"),
        variable_step=True,
        internal_step=None,
    )


def _resized(variable: FmuVariable, sizes: dict[str, int]) -> FmuVariable:
    written = zip(variable.declared.dimensions, variable.shape, strict=True)
    shape = tuple(sizes.get(d, n) if isinstance(d, str) else n for d, n in written)
    return replace(variable, shape=shape)

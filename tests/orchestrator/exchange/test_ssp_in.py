"""Packages as other tools write them run to exact values, or say why not."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from packages import (
    VERSION,
    annotated,
    binding,
    component,
    connections,
    connectors,
    experiment,
    linear,
    mapped,
    mapping,
    package,
    parameter_set,
    ssd,
    unit,
)
from small_packages import KINDS, OSP, STEP, elements, values
from stub import Stub, stub

from orchestrator.errors import ScenarioError
from orchestrator.exchange.ssp.load import load_package, read_package, schema_faults


@pytest.fixture(autouse=True, params=["1.0", "2.0"])
def version(request: pytest.FixtureRequest) -> Iterator[str]:
    every = request.config.getoption("--every-form")
    if request.param == "2.0" and not every and "nested" not in request.node.name:
        pytest.skip("SSP 2.0 reads as 1.0 does: --every-form tries every test")
    VERSION.append(request.param)
    yield request.param
    VERSION.pop()


def test_a_nested_system_wired_against_the_flow_without_steps(
    plain: Path, tmp_path: Path
) -> None:
    """The structure of a published drive: an inner system reached over its border,
    every connection written from the end to the start, neither stop nor step."""
    inner = elements(component("first stage", "resources/a.fmu", KINDS))
    inner += connections("first stage.u -> u_in", "y_out -> first stage.y")
    border = connectors(u_in="input", y_out="output")
    drive = f'<ssd:System name="drive">{border}{inner}</ssd:System>'
    source = component(
        "source", "resources/a.fmu", KINDS + binding(parameter_set('k Real value="3"'))
    )
    sink = component("sink", "resources/a.fmu", KINDS)
    wires = connections("drive.u_in -> source.y", "sink.u -> drive.y_out")
    text = ssd(elements(source, drive, sink) + wires)
    file = package(
        tmp_path / "a.ssp", {"SystemStructure.ssd": text, "resources/a.fmu": plain}
    )
    assert schema_faults(file) == []
    with pytest.raises(ScenarioError) as refused:
        load_package(file)
    assert (
        "add --set rates.step=..., for instance 1/500 s, which a.fmu proposes"
        in str(refused.value)
    )
    assert "add --set stop=..." in str(refused.value)
    sets = ("rates.step=1/500", "stop=0.01")
    spec = load_package(file, sets).spec
    assert spec.connections == {
        "first_stage.u": "source.y",
        "sink.u": "first_stage.y",
    }
    assert values(file, tmp_path / "run", "sink.y", sets=sets) == [3.0]


def test_transformations_stand_on_connections_and_in_mappings(
    compiled: Path, tmp_path: Path
) -> None:
    """Against numbers worked out by hand: millimetres into metres and degrees."""
    of_mm = stub(
        compiled,
        tmp_path / "mm.fmu",
        {
            "u": Stub("input", unit="m"),
            "k": Stub("parameter", unit="m"),
            "y": Stub("output", unit="m"),
        },
    )
    of_offset = mapping(f"offset k|{linear(4)}")
    units = unit("mm", 'm="1" factor="0.001"', "ssv")
    given = parameter_set('offset Real value="500" unit="mm"').replace(
        "</ssv:Parameters>", f"</ssv:Parameters>{units}"
    )
    first = component("a", "r.fmu", KINDS + binding(given, maps=of_offset))
    wires = connections(
        f"a.y -> b.u||{linear(-3)}",
        f'a.y -> c.u|suppressUnitConversion="true"|{linear(0.1, 0.3)}',
        "c.y -> d.u",
    )
    parts = elements(first, *(component(n, "r.fmu", KINDS) for n in "bcd"))
    file = package(
        tmp_path / "a.ssp",
        {
            "SystemStructure.ssd": ssd(parts + wires, experiment(annotations=STEP)),
            "r.fmu": of_mm,
        },
    )
    names = ("a.y", "b.y", "c.y", "d.y")
    a = 4 * (0.001 * 500)
    expected = [a, -3 * a, 0.1 * a + 0.3, 0.1 * a + 0.3]
    assert values(file, tmp_path / "run", *names) == expected


def test_units_of_connectors_count_where_the_fmu_says_none(
    plain: Path, tmp_path: Path
) -> None:
    units = unit("[mm]", 'm="1" factor="0.001"')
    one = connectors(k="parameter", y="output [m]")
    two = connectors(u="input [mm]", y="output")
    set_k = binding(parameter_set('k Real value="2"'))
    parts = elements(component("a", "r.fmu", one + set_k), component("b", "r.fmu", two))
    text = ssd(parts + connections("a.y -> b.u"), units + experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    assert values(file, tmp_path / "run", "b.y") == [2000.0]


def test_external_sets_with_empty_sources_and_parameter_connectors(
    compiled: Path, tmp_path: Path
) -> None:
    """The structure of a published aircraft: one set and one mapping for the whole
    system, 201 entries without source, 190 parameter connectors, 22 connections."""
    variables = {f"in.{i}": Stub("input") for i in range(12)}
    variables |= {f"par[{i}]": Stub("parameter") for i in range(95)}
    variables |= {f"out.{i}": Stub("output") for i in range(12)}
    fmu = stub(compiled, tmp_path / "x.fmu", variables)
    kinds = connectors(**{n: v.causality for n, v in variables.items()})
    wires = [f"a.out.{i} -> b.in.{i}" for i in range(12)]
    wires += [f"b.out.{i + 1} -> c.in.{i}" for i in range(10)]
    assert len(wires) == 22

    entries = [f" a.par[{i}]" for i in range(201)]
    entries += [
        f"wing.p{i} {e}.par[{i}]|{linear(2, 1)}" for e in "ab" for i in range(95)
    ]
    members = {
        "SystemStructure.ssd": ssd(
            binding(
                source="resources/p.ssv",
                prefix="wing.",
                maps=mapping(source="resources/p.ssm"),
            )
            + elements(*(component(n, "resources/x.fmu", kinds) for n in "abc"))
            + connections(*wires),
            experiment(annotations=STEP),
        ),
        "resources/p.ssv": parameter_set(
            *(f'p{i} Real value="{i}.5"' for i in range(96))
        ),
        "resources/p.ssm": mapped(*entries),
        "resources/x.fmu": fmu,
    }
    file = package(tmp_path / "a.ssp", members)
    assert schema_faults(file) == []
    tables = read_package(file)
    assert "201 entries of the mapping have no source" in " ".join(tables.notes)
    spec = load_package(file).spec
    assert len(spec.connections) == 22
    assert sum(len(c.parameters) for c in spec.components.values()) == 190
    assert (
        values(file, tmp_path / "run", "b.out.3", "c.out.2") == [2 * (2 * 3.5 + 1)] * 2
    )


def test_outer_values_go_before_inner_and_later_before_earlier(
    plain: Path, tmp_path: Path
) -> None:
    def of(text: str) -> str:
        return binding(parameter_set(f'k Real value="{text}"'))

    two = of("1") + of("2")
    two = two.replace("</ssd:ParameterBindings><ssd:ParameterBindings>", "")
    kinds = connectors(k="parameter", y="output")
    inner = of("5").replace('name="k"', 'name="a.k"')
    border = connectors(gain="parameter")
    parts = elements(
        component("a", "r.fmu", kinds + two),
        component("b", "r.fmu", kinds + two),
        component("c", "r.fmu", kinds),
        component("d", "r.fmu", kinds + of("4")),
    )
    wires = connections("gain -> c.k", "c.k -> d.k")
    system = f'<ssd:System name="s">{border}{inner}{parts}{wires}</ssd:System>'
    outer = binding(parameter_set('s.gain Real value="7"', 'nobody Real value="1"'))
    text = ssd(outer + elements(system), experiment(annotations=STEP))
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    names = ("a.y", "b.y", "c.y", "d.y")
    assert values(file, tmp_path / "run", *names) == [5.0, 2.0, 7.0, 7.0]
    assert "fit no variable and set nothing: nobody" in " ".join(
        read_package(file).notes
    )


def test_values_of_every_type_arrive_as_such(compiled: Path, tmp_path: Path) -> None:
    kinds = ("Real", "Integer", "Boolean", "String", "Enumeration")
    variables = {
        f"p {k}": Stub("parameter", k, start="1" if k == "Enumeration" else "")
        for k in kinds
    }
    variables = {
        n: v._replace(start=v.start or ("0" if v.type != "String" else ""))
        for n, v in variables.items()
    }
    fmu = stub(compiled, tmp_path / "t.fmu", variables | {"y": Stub("output")})
    lines = [
        f'<ssv:Parameter name="p {k}"><ssv:{k} value="{v}"/></ssv:Parameter>'
        for k, v in zip(kinds, ("0.1", "-7", "true", "deutsch", "on"), strict=True)
    ]
    given = parameter_set().replace(
        "<ssv:Parameters>", "<ssv:Parameters>" + "".join(lines)
    )
    text = ssd(
        elements(component("a", "t.fmu", connectors(y="output") + binding(given))),
        experiment(annotations=STEP),
    )
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "t.fmu": fmu})
    assert load_package(file).spec.components["a"].parameters == {
        "p Real": 0.1, "p Integer": -7, "p Boolean": True, "p String": "deutsch",
        "p Enumeration": "on",
    }  # fmt: skip
    values(file, tmp_path / "run", "a.y")


MASTERS = {
    "OMSimulator": annotated(
        "org.openmodelica",
        '<oms:Annotations xmlns:oms="x"><oms:SimulationInformation>'
        '<oms:FixedStepMaster description="oms-ma" stepSize="0.001000" '
        'absoluteTolerance="0.0001" relativeTolerance="0.0001"/>'
        "</oms:SimulationInformation></oms:Annotations>",
    ),
    "earlier OSP": annotated(
        "org.open-simulation-platform",
        '<osp:SimulationInformation xmlns:osp="x">'
        '<osp:FixedStepMaster description="a" stepSize="1e-3"/>'
        "</osp:SimulationInformation>",
    ),
}
HINT = annotated(OSP, '<osp:StepSizeHint xmlns:osp="x" value="0.0025"/>')


@pytest.mark.parametrize("master", MASTERS)
def test_steps_of_other_masters_are_read_exactly(
    plain: Path, tmp_path: Path, master: str
) -> None:
    parts = elements(
        component("a", "r.fmu", KINDS), component("b", "r.fmu", KINDS + HINT)
    )
    text = ssd(parts + connections("a.y -> b.u") + MASTERS[master], experiment())
    file = package(tmp_path / "a.ssp", {"SystemStructure.ssd": text, "r.fmu": plain})
    spec = load_package(file).spec
    assert [str(c.step) for c in spec.components.values()] == ["1/1000", "1/400"]


def test_a_variant_is_chosen_and_packages_nest(plain: Path, tmp_path: Path) -> None:
    border = connectors(y="output")
    wires = connections("a.y -> y")

    def of(k: str) -> str:
        inner = KINDS + binding(parameter_set(f'k Real value="{k}"'))
        return ssd(
            border + elements(component("a", "r.fmu", inner)) + wires,
            experiment(annotations=STEP),
            name=f"v{k}",
        )

    inner = package(
        tmp_path / "inner.ssp", {"one.ssd": of("1"), "two.ssd": of("2"), "r.fmu": plain}
    )
    with pytest.raises(ScenarioError, match=r"--variant: one\.ssd, two\.ssd"):
        load_package(inner)
    assert load_package(inner, variant="two").spec.components["a"].parameters == {
        "k": 2
    }
    about = 'type="application/x-ssp-package"'
    nested = component("n", "inner.ssp#one.ssd", border, about)
    outer = ssd(
        elements(nested, component("b", "r.fmu", KINDS)) + connections("n.y -> b.u"),
        experiment(annotations=STEP),
    )
    file = package(
        tmp_path / "a.ssp",
        {"SystemStructure.ssd": outer, "inner.ssp": inner, "r.fmu": plain},
    )
    assert values(file, tmp_path / "run", "b.y") == [1.0]

"""Every variable of every model tells what it measures, or there is a reason."""

import zipfile
from collections import Counter

import numpy as np
import pytest
from lxml import etree
from modules import EXCHANGED, MODULES
from subject import subject

from fmus.build import build
from fmus.quantities import (
    FACTORS,
    KINDS,
    SIGNALS,
    bounds,
    nominal,
    quantity,
    shown,
    why_empty,
)
from fmus.units import base_unit

REACH = 100  # between the usual size of a state and what a plausible run shows


def cells(variable):
    low, high = bounds(variable)
    return {
        "quantity": quantity(variable),
        "nominal": nominal(variable),
        "display": shown(variable),
        "min": low,
        "max": high,
    }


def test_every_empty_cell_of_the_table_has_a_reason():
    """Prints the table of ``docs/your-tool.md`` (``pytest -rP``)."""
    filled: dict[str, Counter[str]] = {}
    reasons: Counter[tuple[str, str]] = Counter()
    for module in MODULES:
        for v in subject(module).layout.variables:
            row = filled.setdefault(v.block, Counter())
            row["variables"] += 1
            for cell, content in cells(v).items():
                row[cell] += content is not None
                if content is None:
                    reason = why_empty(v, cell)
                    assert reason, f"{module} {v.name} {cell}"
                    reasons[cell, reason] += 1
            if v.block in SIGNALS and not v.boolean:
                assert v.var.unit in KINDS or v.var.nominal, f"{module} {v.name}"
    print(len(MODULES), "models")
    for block, row in filled.items():
        print(block, *(f"{cell} {n}" for cell, n in row.items()), sep=" | ")
    for (cell, reason), n in sorted(reasons.items()):
        print(f"no {cell}, {reason}: {n}")
    total = sum(filled.values(), Counter())
    assert total["variables"] > 1500
    assert total["quantity"] > 0.6 * total["variables"]


@pytest.mark.parametrize("module", EXCHANGED)
def test_usual_sizes_of_continuous_states_are_those_of_a_run(module):
    """A variable-step solver is blind to what is far below the nominal value."""
    s = subject(module)
    largest = np.max(np.abs(s.expected), axis=0)[s.layout.count["output"] :]
    for v in s.layout.block("state"):
        first = v.reference - s.layout.offset["state"]
        size = np.max(largest[first : first + v.size])
        assert size == 0 or size > nominal(v) / REACH, f"{v.name}: {size:.2g}"


@pytest.mark.parametrize("fmi", [2, 3])
def test_types_and_display_units_are_declared_as_they_are_used(fmi):
    with zipfile.ZipFile(build("plants.ball_screw.drive", fmi=fmi)) as archive:
        root = etree.fromstring(archive.read("modelDescription.xml"))
    declared = {
        t.get("name"): t if fmi == 3 else t.find("Real")
        for t in root.iterfind("TypeDefinitions/*")
    }
    display = {
        (unit.get("name"), inner.get("name")): float(inner.get("factor"))
        for unit in root.iterfind("UnitDefinitions/Unit")
        for inner in unit.iterfind("DisplayUnit")
    }
    used = 0
    for real in [*root.iter("Float64"), *root.iterfind(".//ScalarVariable/Real")]:
        name = real.get("declaredType")
        if name is None:
            continue
        used += 1
        for key in ("quantity", "unit", "displayUnit"):
            assert real.get(key) == declared[name].get(key)
        if real.get("displayUnit"):
            assert (real.get("unit"), real.get("displayUnit")) in display
    assert used > 30
    tolerance = root.find("DefaultExperiment").get("tolerance")
    assert float(tolerance) == 1e-6


def test_display_factors_are_those_of_the_units():
    for (unit, display), factor in FACTORS.items():
        of, to = base_unit(unit), base_unit(display)
        turns = 1.0 if display != "1/min" else 2 * np.pi  # 1/min counts no radians
        assert factor == pytest.approx(of.factor / to.factor / turns, rel=1e-14)

"""Parameters by name reach the records they are meant for, and no others."""

from typing import Annotated, NamedTuple

import pytest

from controllers.synthesis.parameters import share, with_values
from fmus.model import Var


class Inner(NamedTuple):
    f_hz: Annotated[float, Var("Hz", "frequency")] = 50.0


class Plant(NamedTuple):
    m: Annotated[float, Var("kg", "mass")] = 1.0
    k: Annotated[float, Var("N/m", "stiffness")] = 2.0


class Law(NamedTuple):
    m: Annotated[float, Var("kg", "mass")] = 1.0
    inner: Inner = Inner()


RECORDS = {"plant": Plant(), "law": Law()}


def test_a_plain_name_reaches_every_record_that_has_it():
    plant, law = share({"m": 3.0, "k": 4.0, "inner.f_hz": 60.0}, RECORDS)
    assert plant == Plant(3.0, 4.0)
    assert law == Law(3.0, Inner(60.0))


def test_an_addressed_name_reaches_one_record():
    plant, law = share({"plant.m": 3.0, "law.inner.f_hz": 60.0}, RECORDS)
    assert plant == Plant(3.0)
    assert law == Law(1.0, Inner(60.0))


@pytest.mark.parametrize("name", ["x", "plant.x", "plant.inner.f_hz", "inner"])
def test_an_unknown_name_is_refused(name):
    with pytest.raises(LookupError, match="no parameter"):
        share({name: 1.0}, RECORDS)


def test_an_unknown_field_is_refused_with_those_there_are():
    with pytest.raises(LookupError, match=r"there are m, inner\.f_hz"):
        with_values(Law(), {"f_hz": 1.0})

"""What the studies say of their sources: the numbers stand, every figure is judged.

Counts and sums are of the numbers and bounds that the source prints at a place, each
once though ours may be computed in several ways.
"""

from collections import defaultdict
from pathlib import Path

import pytest

from orchestrator.reproduction.published import Statement
from orchestrator.reproduction.reference import read_reference
from orchestrator.reproduction.reproduce import reproduce
from orchestrator.reproduction.verdict import MEANING, summary
from orchestrator.scenario.reading import STUDIES, find_study

PUBLISHED: dict[str, dict[tuple[str, str], tuple[int, float]]] = {
    "cascade_nppi": {
        ("Table 2", "mm"): (11, 1.7477),
        ("Sec. 3.1, 3.2", "V.s/mm"): (2, 0.013214),  # the printed gains, twice
        ("Sec. 3.1, 3.2", "V/mm"): (2, 0.2415),
        ("Sec. 3.1, 3.2", "1/s"): (2, 450),
        ("2.2", "s"): (1, 0.0012),
        ("Table 1", "1"): (3, 10.5403),
        ("Sec. 4, abstract", "%"): (2, 22.26),
        ("Sec. 3.1", "dB"): (1, 9.31),
        ("Sec. 3.1", "deg"): (1, 56.4),
        ("Sec. 3.2", "dB"): (1, 9.1),
        ("Sec. 3.2", "deg"): (1, 67.1),
        ("Sec. 3.3, table 1", "1"): (6, 22.8834),
        ("Sec. 4", "1"): (2, 1.6),
        ("Fig. 8", "1"): (1, -0.2622),
    },
    "ball_screw_pole_placement": {
        ("Table 3.2", "um"): (32, 140.87),
        ("3.5, from Table 3.2", "%"): (8, 399.1),
        ("3.5, abstract", "%"): (8, 430),
        ("3.4", "s"): (9, 4.83),
        ("3.3", "Hz"): (46, 5213),
        ("3.3", "deg"): (11, 330),
        ("3.3", "1"): (17, 48.89),
        ("3.3", "rad/V"): (3, -0.0363),
        ("3.2.1", "Hz"): (2, 130.07),
        ("3.2.1", "1"): (1, 0.027),
        ("5.1", "Hz"): (1, 100),
        ("5.1", "um"): (1, 3.9),
    },
    "gantry": {
        ("4.5, fig. 4.18, 4.19", "nm"): (9, 1220),
        ("4.5, fig. 4.18, 4.19", "um"): (12, 44.146),
        ("4.5, fig. 4.22", "um"): (8, 9.32),
        ("4.5, fig. 4.20", "nm"): (4, 220),
        ("4.5, fig. 4.21", "nm"): (4, 320),
        ("4.5", "um"): (4, 45.2),
        ("4.4.2", "Hz"): (12, 873),
        ("4.4.2", "1"): (5, 13),
        ("4.4.2, fig. 4.15", "Hz"): (4, 94),
        ("fig. 4.15", "Hz"): (10, 967),
        ("fig. 4.15", "1"): (6, 24),
        ("fig. 4.11", "Hz"): (1, 94),
        ("4.4.1", "Hz"): (3, 326),
        ("4.4.1", "deg"): (2, 70),
        ("eq. 4.17", "deg"): (1, 126),
        ("4.4.1", "1"): (1, 4.2),
        ("eq. 4.26", "Hz"): (1, 60),
        ("eq. 4.26", "deg"): (1, 40),
        ("4.4.2", "%"): (1, 590),
        ("4.3.3", "Hz"): (1, 94.3),
        ("4.3.3", "%"): (4, 0),
        ("4.3.3", "1"): (1, 0.034),
        ("eq. 4.16", "V.m.s2/rad"): (1, 0.4342),
        ("eq. 4.16", "V.m.s/rad"): (1, 18.17),
        ("eq. 4.16", "V.m/rad"): (1, 159200),
        ("4.3.3", "V.s2/m"): (1, 2.722),
        ("4.5", "1"): (2, 20.78),
    },
    "leadscrew_nctf": {
        ("Table 5-2", "s"): (16, 2.98435),
        ("Table 5-2", "%"): (8, 0.72),
        ("Table 5-3", "s"): (16, 2.86661),
        ("Table 5-3", "%"): (8, 0.36),
        ("Sec. 5.2", "%"): (8, 249),
        ("Tables 5-2 and 5-3", "%"): (8, 249),
        ("Fig. 3-10", "%"): (2, 9.31),
        ("Fig. 4-13", "nm"): (14, 0),
        ("Fig. 3-13", "nm"): (14, 0),
        ("Fig. 4-14", "nm"): (4, 30),
        ("Fig. 3-14", "nm"): (4, 30),
        ("Fig. 3-2", "mm"): (1, 48.5),
        ("Eq. 3-8", "mm/(A.s)"): (1, 32.3),
        ("Sec. 3.1.1", "1/s"): (1, 505),
        ("Fig. 4-3", "mm"): (3, 53),
        ("Fig. 4-3", "nm"): (3, 855),
        ("Fig. 4-3", "Hz"): (3, 664),
        ("Sec. 4.1", "nm"): (2, 69),
        ("Sec. 3.1.4", "A.s/mm"): (2, 4.8),
        ("Table 2-1", "A.s/mm"): (1, 2.4),
        ("Eq. 3-15", "1"): (3, 70.95),
        ("Fig. 3-6", "1"): (3, 3),
        ("Table 4-1", "Hz"): (5, 339),
        ("Fig. 4-4", "Hz"): (8, 1640),
        ("Fig. 4-4", "nm"): (8, 460),
        ("Sec. 4.2", "Hz"): (4, 244),
        ("Sec. 4.2", "1"): (4, 2.8316),
        ("Fig. 4-5", "Hz"): (2, 363),
        ("Table 6-1", "um"): (6, 1924.94),
        ("Table 6-2", "um"): (6, 79.944),
        ("Table 6-3", "um"): (6, 3238.09),
        ("Table 6-4", "nm"): (6, 552.2),
        ("Table 6-5", "nm"): (6, 964.4),
        ("Table 6-6", "nm"): (9, 402.2),
        ("Table 6-7", "nm"): (3, 30.2),
        ("Table 6-7, on the reading", "nm"): (3, 30.2),  # the same three
        ("Sec. 6.3.3", "%"): (2, 3.5),
        ("Sec. 7.2", "1"): (3, 2.52),
        ("Sec. 7.3", "1"): (3, 2.82),
        ("Sec. 7.2", "%"): (1, 16),
        ("Sec. 7.3", "%"): (1, 6),
        ("App. A.3", "N.m.s/rad"): (6, 0.00566),
        ("App. A.3", "N.m"): (6, 0.35091),
        ("Fig. 4-2", "Hz"): (1, 220),
        ("Sec. 7.1", "%"): (1, 10),
        # printed above, held against runs of other procedures
        ("Sec. 3.1.4, by bisection", "A.s/mm"): (2, 4.8),
        ("Table 2-1, by bisection", "A.s/mm"): (1, 2.4),
        ("Fig. 3-6, by bisection", "1"): (6, 6),
        ("Sec. 7.2, by bisection", "%"): (1, 16),
        ("Sec. 7.3, by bisection", "%"): (1, 6),
        ("App. A.3, one pulse", "mm"): (9, 221.010705),
        ("Sec. 3.3, 4.5", "%"): (4, 75),
        ("Sec. 4.4, by a sweep", "Hz"): (1, 215),
        ("Sec. 4.4, by a pulse", "Hz"): (1, 215),
        ("Sec. 4.4, by a pulse", "nm"): (1, 290),
        ("Table 6-7, 20 repeats", "nm"): (6, 33.6),
        ("Tables 5-2 and 5-3, 50 repeats", "s"): (8, 0.175739),
        ("Tables 5-2 and 5-3, 50 repeats", "%"): (4, 0.84),
    },
}


@pytest.mark.parametrize("study", PUBLISHED)
def test_every_published_number_stands_with_its_place_and_unit(study: str) -> None:
    found: dict[tuple[str, str], dict[str, tuple[float, ...]]] = defaultdict(dict)
    for spec in read_reference(find_study(study) / "reference.toml").figures.values():
        said = spec.published
        if isinstance(said, Statement):
            bounds = (said.below, said.above, *(said.between or ()))
            numbers = tuple(x for x in bounds if x is not None and not said.says)
        else:
            numbers = (said,) if isinstance(said, float) else ()
        if numbers:
            found[spec.where, spec.unit][spec.id.partition("@")[0]] = numbers
    counted = {
        place: (sum(map(len, rows.values())), sum(map(sum, rows.values())))
        for place, rows in found.items()
    }
    assert counted.keys() == PUBLISHED[study].keys()
    for place, (count, total) in PUBLISHED[study].items():
        found_count, found_total = counted[place]
        assert found_count == count, place
        assert found_total == pytest.approx(total, rel=1e-5, abs=1e-9), place


@pytest.mark.parametrize(
    "file", sorted(STUDIES.glob("*/reference.toml")), ids=lambda f: f.parent.name
)
def test_few_figures_stand_beside_nothing_published(file: Path) -> None:
    rows = read_reference(file).figures.values()
    alone = [r.id for r in rows if r.published is None and r.class_ != "out of reach"]
    assert len(alone) <= 20, alone


@pytest.mark.parametrize(
    ("study", "figure"),
    [
        ("leadscrew_nctf", "windup.off.settling_10nm@tab"),
        ("ball_screw_pole_placement", "p_pi_a.tracking_80.magnitude"),
    ],
)
def test_what_the_source_denies_is_a_contradiction_though_our_acceptance_holds(
    study: str, figure: str, tmp_path: Path
) -> None:
    (found,) = reproduce(study, figure, processes=1, folder=tmp_path).figures
    assert (found.verdict, found.regression) == ("contradicts", "holds")
    assert found.why


@pytest.mark.parametrize("study", PUBLISHED)
def test_every_figure_is_judged_and_every_difference_has_its_reason(
    study: str, tmp_path: Path, request: pytest.FixtureRequest
) -> None:
    if study != "cascade_nppi" and not request.config.getoption("--every-form"):
        pytest.skip("runs every scenario of the study; --every-form")
    figures = reproduce(study, folder=tmp_path).figures
    counts = summary(figures)
    assert [f.spec.id for f in figures if f.regression == "FAILED"] == []
    assert counts["without why"] == []
    judged = {verdict: sum(of.values()) for verdict, of in counts["verdicts"].items()}
    assert judged.keys() == MEANING.keys()
    assert sum(judged.values()) == len(figures)
    unjudged = [f for f in figures if f.verdict == "computed"]
    assert [f.spec.id for f in unjudged if f.spec.published is not None] == []
    assert [f.spec.id for f in unjudged if not f.why] == []

"""What the shell offers for a name that has been begun."""

from collections.abc import Iterator


def scenario_names(incomplete: str) -> Iterator[str]:
    """Yield the scenarios of the studies that begin so."""
    from orchestrator.scenario import reading

    for folder in reading.studies():
        for file in reading.scenarios(folder).values():
            if (name := reading.scenario_name(file)).startswith(incomplete):
                yield name


def study_names(incomplete: str) -> Iterator[str]:
    """Yield the studies that begin so."""
    from orchestrator.scenario import reading

    yield from (f.name for f in reading.studies() if f.name.startswith(incomplete))


def run_names(incomplete: str) -> Iterator[str]:
    """Yield the runs in runs/ that begin so."""
    from orchestrator.history.folder import RUNS
    from orchestrator.history.listing import entries

    yield from (e.name for e in entries(RUNS) if e.name.startswith(incomplete))

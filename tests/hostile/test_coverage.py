"""How many branches of our C the programs under sanitizers take, file by file.

Random calls, changed states and the hosts of kernel and channel, compiled again so that
gcc counts.  What they leave is told; a file of which they leave much fails.
"""

import gzip
import json
import subprocess
import zipfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from pathlib import Path

from tools import needed

from fmus.build import build
from orchestrator.fmu.description import read_fmu
from orchestrator.native.library import SOURCES

TESTS = Path(__file__).parents[1]
SMALL, MODELS = TESTS / "fmus" / "small_models", TESTS / "orchestrator" / "models"
COUNTED = ["gcc", "-O0", "-g", "--coverage", "-std=gnu11", "-w"]
COUNTED += ["-Dalways_inline=unused"]  # else every place it is inlined at counts
DENIED = ["-DNO_MEMORY", "-Wl,--wrap=malloc,--wrap=calloc"]


def programs(folder: Path) -> Iterator[tuple[list[str], list[str]]]:
    """Give what each program is compiled of, and the words it is run with."""
    for model in ("pi", "spring_mass", "late", "matrices", "scheduled"):
        fmu, place = build(str(SMALL / f"{model}.py")), folder / model
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(place)
        described = read_fmu(fmu)
        files = [str(f) for f in place.glob("sources/*.c") if f.stem != "all"]
        files += ["-I", str(place / "sources"), f'-DTOKEN="{described.token}"']
        driver = str(TESTS / "fmus" / "random_calls.c")
        for fmi in (2, 3):
            yield [driver, f"-DFMI={fmi}", *DENIED, *files], ["200000", "1"]
        reference = described[described.inputs[0]].reference
        states = str(Path(__file__).with_name("states.c"))
        yield [states, f"-DINPUT_REFERENCE={reference}", *files], ["20000", "1"]
    others = [str(f) for f in SOURCES if f.suffix == ".c"]
    support = TESTS / "support"
    for model in ("counter", "integrator"):
        fmu, place = build(str(MODELS / f"{model}.py"), fmi=3), folder / model
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(place)
        described = read_fmu(fmu)
        files = [str(f) for f in place.glob("sources/*.c") if f.stem != "all"]
        files += [f for f in others if not f.endswith("kernel.c")]  # the host has it
        files += ["-I", str(place / "sources"), f'-DTOKEN="{described.token}"']
        files += [f"-DINPUT_REFERENCE={described['u'].reference}"]
        files += [f"-DOUTPUT_REFERENCE={described[described.outputs[0]].reference}"]
        files += [f"-DCLOCK_REFERENCE={described.clock or 0}"]
        files += [f"-DCLOCKED={int(described.clock is not None)}"]
        yield [str(support / "kernel_host.c"), *files], []
    native = ["-I", str(Path(build.__code__.co_filename).parent / "native")]
    yield [str(TESTS / "fmus" / "elementary_paths.c"), *native], []
    for paths in ("kernel_paths.c", "channel_paths.c"):
        yield [str(support / paths)], []
    rest = [f for f in others if not f.endswith("channel.c")]
    yield [str(support / "channel_host.c"), *rest, "-pthread"], []


def counted(folder: Path) -> dict[str, dict[tuple[int, int], int]]:
    """Return how often each branch was taken: file -> (line, number) -> times."""
    found: dict[str, dict[tuple[int, int], int]] = defaultdict(dict)
    for data in sorted(folder.glob("*.gcda")):
        command = ["gcov", "--branch-probabilities", "--json-format", str(data)]
        subprocess.run(command, cwd=folder, check=True, capture_output=True)
        for report in folder.glob("*.gcov.json.gz"):
            told = json.loads(gzip.decompress(report.read_bytes()))
            report.unlink()
            for file in told["files"]:
                taken = found[Path(file["file"]).name]
                for line in file["lines"]:
                    for number, branch in enumerate(line["branches"]):
                        at = line["line_number"], number
                        taken[at] = taken.get(at, 0) + branch["count"]
    return found


def test_branches_of_our_c_are_taken(
    tmp_path: Path, record_property: Callable[[str, object], None]
) -> None:
    needed("gcc", "gcov")
    whole: dict[str, dict[tuple[int, int], int]] = defaultdict(dict)
    for number, (sources, words) in enumerate(programs(tmp_path)):
        place = tmp_path / f"program {number}"
        place.mkdir()
        command = [*COUNTED, *sources, "-lm", "-o", "it"]
        subprocess.run(command, cwd=place, check=True, capture_output=True)
        subprocess.run(["./it", *words], cwd=place, check=True, capture_output=True)
        for file, branches in counted(place).items():
            for at, times in branches.items():
                whole[file][at] = whole[file].get(at, 0) + times
    native = Path(build.__code__.co_filename).parent / "native"
    ours = {f.name for f in (*SOURCES, *native.iterdir())}
    figures = {}
    for file in sorted(ours & whole.keys()):
        if branches := whole[file]:
            taken = sum(times > 0 for times in branches.values())
            figures[file] = taken, len(branches)
            record_property("told", f"{file}: {taken} of {len(branches)} branches")
    all_taken, total = (sum(column) for column in zip(*figures.values(), strict=True))
    record_property("told", f"all: {all_taken} of {total} branches")
    assert {f: n for f, n in figures.items() if n[0] < 0.94 * n[1]} == {}
    assert all_taken > 0.97 * total
    assert len(figures) >= 20

"""Kernel and adapters neither leak nor touch what is not theirs."""

import shutil
import subprocess
from pathlib import Path

import pytest
from systems import MODELS
from tools import needed

from fmus.build import build
from fmus.native_source import adapter_sources, source_names
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import read_fmu
from orchestrator.native.library import SOURCES

HOST = Path(__file__).parents[2] / "support" / "kernel_host.c"
SANITIZERS = "-fsanitize=address,undefined"


@pytest.mark.skipif(not shutil.which("gcc"), reason="zig brings no address sanitizer")
@pytest.mark.parametrize("model", ["counter", "integrator"])
def test_1000_instances_leave_nothing_behind(model: str, tmp_path: Path) -> None:
    """Create, run by the kernel in both versions of FMI, free; under gcc's sanitizers.

    The FMU's own sources are compiled with the kernel into one program.
    """
    fmu = build(str(MODELS / f"{model}.py"), fmi=3)
    with unpacked(fmu) as folder:
        sources = folder / "sources"
        files = [sources / name for name in source_names(adapter_sources())]
        others = [file for file in SOURCES if file.name != "kernel.c"]  # HOST has it
        files += [sources / "model_data.c", *others, HOST]
        described = read_fmu(fmu)
        flags = ["-O1", "-g", "-std=gnu11", "-ffp-contract=off", SANITIZERS]
        flags += [
            "-fno-sanitize-recover=all",
            f"-I{sources}",
            f'-DTOKEN="{described.token}"',
        ]
        references = {
            "INPUT": described["u"].reference,
            "OUTPUT": described[described.outputs[0]].reference,
            "CLOCK": described.clock or 0,
        }
        flags += [f"-D{name}_REFERENCE={r}" for name, r in references.items()]
        flags += [f"-DCLOCKED={int(described.clock is not None)}"]
        program = tmp_path / "host"
        command = ["gcc", *flags, *map(str, files), "-lm", "-o", str(program)]
        subprocess.run(command, check=True, capture_output=True)
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout == "1000 instances\n"


@pytest.mark.parametrize("paths", ["kernel_paths", "channel_paths"])
def test_every_way_through_kernel_and_channel_is_what_it_is_said_to_be(
    paths: str, tmp_path: Path
) -> None:
    """Types, copies, faults, clocks, each failure of each call; turns of any end."""
    needed("gcc")
    program = tmp_path / "paths"
    flags = ["-O1", "-g", "-std=gnu11", SANITIZERS, "-fno-sanitize-recover=all"]
    source = HOST.with_name(f"{paths}.c")
    command = ["gcc", *flags, str(source), "-lm", "-o", str(program)]
    subprocess.run(command, check=True)
    done = subprocess.run([program], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (0, "every way\n"), done.stderr[-2000:]


@pytest.mark.skipif(not shutil.which("gcc"), reason="zig brings no sanitizers")
@pytest.mark.parametrize("sanitizers", [SANITIZERS, "-fsanitize=thread"])
def test_a_channel_touches_only_what_is_its_own_and_in_turn(
    sanitizers: str, tmp_path: Path
) -> None:
    """20,000 steps and a refused one, master and server as threads under gcc's."""
    program = tmp_path / "host"
    others = [str(f) for f in SOURCES if f.name in ("turn.c", "kernel.c")]
    flags = ["-O1", "-g", "-std=gnu11", sanitizers, "-fno-sanitize-recover=all"]
    command = ["gcc", *flags, str(HOST.with_name("channel_host.c")), *others]
    subprocess.run(
        [*command, "-lm", "-pthread", "-o", str(program)],
        check=True,
        capture_output=True,
    )
    done = subprocess.run([program], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr[-2000:]
    assert done.stdout == "20000 steps\n"

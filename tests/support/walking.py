"""FMUs walk over the same random steps natively, on an emulated ARM and in wine."""

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from tools import needed

from fmus.compile import PLATFORMS

FMUS = Path(__file__).parents[1] / "fmus"
HOST = FMUS / "walk_host.c"
NATIVE = Path(__file__).parents[2] / "fmus" / "native"
STEPS = 2_000
RUNNERS = {
    "linux-x86_64": (),
    "linux-aarch64": ("qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"),
    "windows-x86_64": ("wine64",),
}
Lines = Mapping[str, Sequence[str]]


class Walk(NamedTuple):
    digest: str
    last: float
    allocations: int


def place_of(library: Path, platform: str) -> str:
    """Return a path as the platform's program takes it."""
    return f"Z:{library}" if platform.startswith("windows") else str(library)


def walks(platform: str, lines: Lines, folder: Path) -> dict[str, list[Walk]]:
    """Return the walks of each model on a platform; lines as walk_host.c reads them."""
    *runner, program = *RUNNERS[platform], folder / f"walk_host-{platform}.exe"
    if runner and runner[0] == "wine64" and not shutil.which("wine64"):
        runner[0] = "/usr/lib/wine/wine64"
    needed(*runner[:1])
    command = [sys.executable, "-m", "ziglang", "cc", "-O2", "-std=c99", "-Wall"]
    command += ["-target", PLATFORMS[platform].triple, "-ffp-contract=off"]
    command += [f"-I{NATIVE}", str(HOST), "-o", str(program)]
    subprocess.run(command, check=True)
    return run([*runner, str(program)], lines, folder / f"{platform}.txt")


def run(command: Sequence[str], lines: Lines, list_file: Path) -> dict[str, list[Walk]]:
    list_file.write_text("\n".join(line for each in lines.values() for line in each))
    wine = Path(command[0]).name.startswith("wine")
    told = f"Z:{list_file}" if wine else str(list_file)
    quiet = os.environ | {
        "WINEDEBUG": "-all",
        "WINEPREFIX": str(list_file.parent / "w"),
    }
    done = subprocess.run(
        [*command, told, str(STEPS)], capture_output=True, text=True, env=quiet
    )
    assert done.returncode == 0, done.stdout[-500:] + done.stderr[-500:]
    rows = iter(done.stdout.split("\n"))
    found = {}
    for module, each in lines.items():
        fields = [next(rows).split() for _ in each]
        found[module] = [Walk(a, float(b), int(c)) for a, b, c in fields]
    return found

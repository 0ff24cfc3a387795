"""A plugin (``pytest -p other_compiler``): all our C is compiled by gcc.

OTHER_FLAGS is what it takes besides: sanitizers, or what counts branches.  Sources and
what the compiler leaves beside them stay in folders below OTHER_KEPT.  Lanes have
vectors that gcc does not know: zig compiles them, and with "undefined" in OTHER_FLAGS
what is undefined ends the process (SIGILL).
"""

import os
import shutil
import subprocess
from collections.abc import Sequence
from hashlib import sha256
from pathlib import Path
from typing import Any

from fmus import compile as compiling

OF_ZIG = ("-mcpu=baseline", "-fno-sanitize=undefined", "-g0", "-s", "-O2", "-std=c99")
OF_ZIG += ("-fno-slp-vectorize",)
TRAPS = ("-fsanitize=undefined", "-fsanitize-trap=undefined")

ZIG = compiling._zig_cc


def cc(target: Any, arguments: Sequence[str], folder: Path) -> None:
    """Compile for this machine, in place of zig."""
    kept = [a for a in arguments if a not in OF_ZIG and not a.startswith("-W")]
    told = sha256(repr(kept).encode())
    for file in sorted(folder.rglob("*.[ch]")):
        told.update(file.read_bytes())
    place = Path(os.environ["OTHER_KEPT"]) / told.hexdigest()[:16]
    name = kept[kept.index("-o") + 1]
    if (place / name).is_file():  # anew, it would lose what it has counted
        shutil.copyfile(place / name, folder / name)
        return
    shutil.copytree(folder, place, dirs_exist_ok=True)
    flags = ["-fPIC", "-g", "-w", "-std=gnu11", *os.environ["OTHER_FLAGS"].split()]
    command = ["gcc", *flags, *kept]
    done = subprocess.run(command, cwd=place, capture_output=True, text=True)
    if done.returncode:
        traps = TRAPS if "undefined" in os.environ["OTHER_FLAGS"] else ()
        return ZIG(target, [*arguments, *traps], folder)
    shutil.copyfile(place / name, folder / name)


def pytest_configure() -> None:
    compiling._zig_cc = cc

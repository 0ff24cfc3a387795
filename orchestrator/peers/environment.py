"""Which Python has which tool, and one job carried out in it.

A tool is looked for, in this order: the Python that the tool's environment
variable names, an environment of its own in the user's cache (``install`` makes
it), the running Python.
"""

import json
import os
import signal
import subprocess
import sys
import tempfile
from array import array
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from orchestrator.errors import FeedDriveError, PluginError
from orchestrator.plugins import load, named

HERE = Path(__file__).parent
PATIENCE = 600.0  # s for one job


class PeerError(FeedDriveError):
    """A tool is not there, refused a job or died of it."""

    exit_code = 1


@dataclass(frozen=True)
class Peer:
    """A tool: what pip installs, what it imports, which file here drives it."""

    name: str
    requirements: tuple[str, ...]
    module: str
    file: str

    @property
    def variable(self) -> str:
        """The environment variable that may name its Python."""
        return f"FEEDDRIVE_PEER_{self.name.upper()}"

    @property
    def folder(self) -> Path:
        """Its own environment in the user's cache."""
        return platformdirs.user_cache_path("feeddrive") / "peers" / self.name


PEERS: Mapping[str, Peer] = {
    peer.name: peer
    for peer in (
        Peer("fmpy", ("fmpy>=0.3.30",), "fmpy", "fmpy_loop.py"),
        Peer("ecospy", ("ecospy>=0.7", "tbb"), "ecospy", "ecospy_tool.py"),
        Peer("libcosimpy", ("libcosimpy",), "libcosimpy", "libcosimpy_tool.py"),
        Peer(
            "fmucontainer",
            ("fmu-manipulation-toolbox>=2",),
            "fmu_manipulation_toolbox",
            "fmucontainer_tool.py",
        ),
    )
}


def every_peer() -> Mapping[str, Peer]:
    """Return the tools by name, ours and those that other packages add.

    Raises:
        PluginError: an entry point of ``feeddrive.peers`` is no ``Peer``.
    """
    found = dict(PEERS)
    for name in named("peers"):
        peer = load("peers", name)
        if not isinstance(peer, Peer):
            raise PluginError(f"feeddrive.peers: {name} is {peer!r}, which is no Peer")
        found[peer.name] = peer
    return found


def python_of(peer: Peer) -> Path:
    """Return the Python that has a tool.

    Raises:
        PeerError: none has it; the message says how to get it.
    """
    if chosen := os.environ.get(peer.variable):
        if not Path(chosen).is_file():
            raise PeerError(f"{peer.variable}={chosen}: no such Python")
        return Path(chosen)
    if (own := _python_in(peer.folder)).is_file():
        return own
    if find_spec(peer.module):
        return Path(sys.executable)
    raise PeerError(
        f"{peer.name} is not installed: give --install to put it into "
        f"{peer.folder}, install feeddrive-cosim[peers], or let {peer.variable} name "
        f"a Python that has it"
    )


def install(peer: Peer) -> Path:
    """Return the Python that has a tool, after installing it if none has.

    Raises:
        PeerError: pip could not.
    """
    try:
        return python_of(peer)
    except PeerError:
        peer.folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=peer.folder.parent) as fresh:
        made = Path(fresh, peer.name)
        pip = [str(_python_in(made)), "-m", "pip", "install", "--quiet"]
        for command in (
            [sys.executable, "-m", "venv", str(made)],
            [*pip, *peer.requirements],
        ):
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            if done.returncode:
                reason = _last(done.stderr)
                raise PeerError(f"{peer.name} cannot be installed: {reason}")
        with suppress(OSError):  # another process was first
            made.rename(peer.folder)
    return python_of(peer)


def version(peer: Peer, python: Path) -> str:
    """Return the version of a tool's package."""
    name = peer.requirements[0].partition(">")[0]
    text = f"from importlib.metadata import version; print(version({name!r}))"
    done = subprocess.run(
        [str(python), "-c", text], capture_output=True, text=True, check=False
    )
    return done.stdout.strip() or "unknown version"


def carry_out(peer: Peer, job: Mapping[str, Any]) -> NDArray[np.float64]:
    """Return what a tool makes of a job: (rows, 1 + signals), its time first.

    Raises:
        PeerError: it is not there, refused, hung or crashed.
    """
    python = python_of(peer)
    target = Path(job["folder"]) / f"{peer.name}.rows"
    command = [str(python), str(HERE / "child.py"), str(HERE / peer.file), str(target)]
    try:
        done = subprocess.run(
            command,
            input=json.dumps(job),
            capture_output=True,
            text=True,
            timeout=PATIENCE,
            check=False,
            cwd=job["folder"],
        )
    except subprocess.TimeoutExpired:
        raise PeerError(f"{peer.name} did not end within {PATIENCE:g} s") from None
    if done.returncode < 0:
        name = signal.Signals(-done.returncode).name
        raise PeerError(f"{peer.name} crashed ({name}); {_last(done.stderr)}")
    if done.returncode:
        raise PeerError(f"{peer.name} refused: {_last(done.stderr)}")
    values = array("d", target.read_bytes())
    return np.array(values).reshape(-1, 1 + len(job["signals"]))


def _last(text: str) -> str:
    """Return the last line of what a process said."""
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it said nothing"


def _python_in(folder: Path) -> Path:
    if sys.platform == "win32":
        return folder / "Scripts" / "python.exe"
    return folder / "bin" / "python"

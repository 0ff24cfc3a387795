"""What the docs say to type: blocks of code, and commands run as they stand."""

import re
import shlex
import subprocess
import sys
from pathlib import Path


def blocks(text: str, language: str) -> list[str]:
    """Return the blocks of a language in a page."""
    return re.findall(rf"```{language}\n(.*?)```", text, re.DOTALL)


def typed(line: str, folder: Path) -> str:
    """Run a command in a folder and return what it printed."""
    command = [sys.executable, "-m", "orchestrator", *shlex.split(line)[1:]]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout

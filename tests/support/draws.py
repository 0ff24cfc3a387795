"""Draws of the hostile suite: the same in every worker, others in every commit."""

import random
import subprocess
from functools import cache
from pathlib import Path


@cache
def seed() -> str:
    """Return what the draws of this commit begin with."""
    done = subprocess.run(
        ["git", "rev-parse", "HEAD"],
        cwd=Path(__file__).parent,
        capture_output=True,
        text=True,
        check=False,
    )
    return done.stdout.strip() or "no commit"


def drawn(what: str) -> random.Random:
    """Return the generator of one kind of draws."""
    return random.Random(f"{seed()} {what}")

"""Programs of the system that some tests need; `.ci/run` installs them."""

import os
import shutil

import pytest


def needed(*programs: str) -> None:
    """Skip a test for want of a program; in CI that is a failure."""
    missing = [program for program in programs if not shutil.which(program)]
    if missing and os.environ.get("CI") == "true":
        pytest.fail(f"{', '.join(missing)}: not installed, though this is CI")
    if missing:
        pytest.skip(f"{', '.join(missing)}: not installed")

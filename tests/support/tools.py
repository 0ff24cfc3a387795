"""Programs of the system that some tests need; `.ci/run` installs them."""

import os
import shutil

import pytest


def needed(*programs: str) -> None:
    """Skip a test for want of a program; in CI that is a failure."""
    if missing := [program for program in programs if not shutil.which(program)]:
        lacking(", ".join(missing))


def lacking(what: str) -> None:
    """Skip a test because this is not installed; in CI that is a failure."""
    if os.environ.get("CI") == "true":
        pytest.fail(f"{what}: not installed, though this is CI")
    pytest.skip(f"{what}: not installed")

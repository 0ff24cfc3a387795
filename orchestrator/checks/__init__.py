"""``feeddrive check``: what is wrong with an FMU, before it is trusted.

Each check is a small function registered under its number with title, clause
of the standard and remedy (``item``); ``engine`` carries them out.
"""

from orchestrator.checks.engine import check_fmu
from orchestrator.checks.report import Report

__all__ = ["Report", "check_fmu"]

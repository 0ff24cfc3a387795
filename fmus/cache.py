"""Where built FMUs, libraries and what was computed once are kept."""

import os
from pathlib import Path

import platformdirs


def cache_folder() -> Path:
    """Return the user's cache folder, or the one that FEEDDRIVE_CACHE names."""
    chosen = os.environ.get("FEEDDRIVE_CACHE")
    return Path(chosen) if chosen else platformdirs.user_cache_path("feeddrive")

"""How scenarios and runs show themselves in a notebook: as the page they have.

The page stands in a frame of its own, so that neither styles the other and nothing is
fetched.  What draws a page stands in rooms above what it draws: it is looked up by
name when a notebook asks.
"""

import tempfile
from collections.abc import Callable
from html import escape
from importlib import import_module
from pathlib import Path

HEIGHT = 720  # pixels of the frame


class Shown:
    """Something with a page: ``PAGE`` is ``module:function``, called with it."""

    PAGE = ""

    def _repr_html_(self) -> str:
        module, _, name = self.PAGE.partition(":")
        return framed(lambda file: getattr(import_module(module), name)(self, file))


def framed(write: Callable[[Path], object]) -> str:
    """Return a frame with the page that ``write`` puts into a file."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "page.html"
        write(file)
        page = file.read_text(encoding="utf-8")
    return (
        f'<iframe title="feeddrive" srcdoc="{escape(page)}" width="100%" '
        f'height="{HEIGHT}" style="border:0"></iframe>'
    )

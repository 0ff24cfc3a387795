"""Data files that belong to a model: tables and designs too long to be typed in.

    DESIGN = json.loads(read_data(__file__, "k_vib.json"))

Such a file lies beside the module that reads it, or in a folder below.  It is part
of the model: of its digest, of the wheel, and of the sources in its FMU.  So that
it is found without importing anything, both arguments are written out as above.
Any other file that a model reads while it is imported or traced is refused.
"""

from pathlib import Path


def read_data(module: str, name: str) -> bytes:
    """Return the content of the data file ``name`` beside ``module``, its __file__.

    Raises:
        OSError: the file cannot be read.
    """
    return Path(module).parent.joinpath(name).read_bytes()

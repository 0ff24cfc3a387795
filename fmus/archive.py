"""FMU archives that do not tell when, where or by whom they were zipped.

Names are sorted, times and attributes are fixed, contents deflated; two
archives are the same FMU when their content digests agree.
"""

from collections.abc import Mapping
from hashlib import sha256
from pathlib import Path
from zipfile import ZIP_DEFLATED, ZipFile, ZipInfo

EPOCH = (1980, 1, 1, 0, 0, 0)  # the earliest a zip can hold
EXTRA = "extra/org.feeddrive/model.xml"  # what our own master reads
READABLE = 0o100644 << 16
UNIX = 3


def write_archive(path: Path, contents: Mapping[str, bytes]) -> Path:
    """Write files given by their names inside the archive; return ``path``.

    Raises:
        ValueError: a name would leave the folder the archive is unpacked in.
    """
    with ZipFile(path, "w") as archive:
        for name, content in sorted(contents.items()):
            if name.startswith("/") or "\\" in name or ".." in name.split("/"):
                raise ValueError(f"{name!r} does not stay inside the archive")
            info = ZipInfo(name, EPOCH)
            info.external_attr, info.create_system = READABLE, UNIX
            archive.writestr(info, content, ZIP_DEFLATED)
    return path


def content_digest(path: Path) -> str:
    """Return a fingerprint (hex) of names and uncompressed bytes of an archive."""
    digest = sha256()
    with ZipFile(path) as archive:
        for name in sorted(archive.namelist()):
            content = archive.read(name)
            digest.update(f"{name}\0{len(content)}\0".encode() + content)
    return digest.hexdigest()

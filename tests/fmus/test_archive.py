import os
import time
import zipfile

import pytest

from fmus.archive import content_digest, write_archive

CONTENTS = {"modelDescription.xml": b"<a/>", "sources/b.c": b"int b;", "a.txt": b""}


def test_the_order_of_writing_and_the_clock_leave_no_trace(tmp_path):
    one = write_archive(tmp_path / "one.fmu", CONTENTS)
    os.utime(one, (time.time() - 1e6,) * 2)
    two = write_archive(tmp_path / "two.fmu", dict(reversed(CONTENTS.items())))
    assert one.read_bytes() == two.read_bytes()
    with zipfile.ZipFile(one) as archive:
        assert archive.namelist() == sorted(CONTENTS)
        assert {info.date_time[0] for info in archive.infolist()} == {1980}


def test_the_digest_sees_names_and_bytes_and_nothing_else(tmp_path):
    one = write_archive(tmp_path / "one.fmu", CONTENTS)
    with zipfile.ZipFile(tmp_path / "stored.fmu", "w") as archive:
        for name, content in reversed(CONTENTS.items()):
            archive.writestr(name, content)
    assert content_digest(one) == content_digest(tmp_path / "stored.fmu")
    other = write_archive(tmp_path / "other.fmu", CONTENTS | {"a.txt": b"x"})
    moved = {"a.tx": b"t"} | CONTENTS
    assert content_digest(one) != content_digest(other)
    assert content_digest(one) != content_digest(
        write_archive(tmp_path / "moved.fmu", moved)
    )


@pytest.mark.parametrize("name", ["../out", "/etc/passwd", "a\\b", "a/../../b"])
def test_a_name_cannot_leave_the_archive(tmp_path, name):
    with pytest.raises(ValueError, match="inside the archive"):
        write_archive(tmp_path / "bad.fmu", {name: b""})

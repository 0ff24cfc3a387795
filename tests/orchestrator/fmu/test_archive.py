"""Untrusted archives are refused before anything is written."""

import stat
import zipfile
from pathlib import Path

import pytest

from fmus.build import build
from orchestrator.errors import FmuError
from orchestrator.fmu.archive import unpacked
from orchestrator.fmu.description import read_fmu


def archive(path: Path, *members: str) -> Path:
    with zipfile.ZipFile(path, "w") as file:
        for member in members:
            file.writestr(member, "x")
    return path


@pytest.mark.parametrize(
    "member",
    ["../outside.txt", "a/../../outside.txt", "/etc/x", "C:/x", "..\\outside.txt"],
)
def test_a_member_that_leaves_the_folder_is_refused(
    member: str, tmp_path: Path
) -> None:
    fmu = archive(tmp_path / "evil.fmu", "modelDescription.xml", member)
    with (
        pytest.raises(FmuError, match=r"evil\.fmu.*member.*refused"),
        unpacked(fmu),
    ):
        pass
    assert [f.name for f in tmp_path.iterdir()] == ["evil.fmu"]


def test_a_symbolic_link_is_refused(tmp_path: Path) -> None:
    fmu = tmp_path / "link.fmu"
    with zipfile.ZipFile(fmu, "w") as file:
        link = zipfile.ZipInfo("resources/link")
        link.external_attr = (stat.S_IFLNK | 0o777) << 16
        file.writestr(link, "/etc/passwd")
    with pytest.raises(FmuError, match="symbolic link"), unpacked(fmu):
        pass


def test_a_truncated_archive_says_so(tmp_path: Path) -> None:
    whole = build("plants.ball_screw.two_mass").read_bytes()
    fmu = tmp_path / "cut.fmu"
    for length in (0, 10, len(whole) // 2, len(whole) - 10):
        fmu.write_bytes(whole[:length])
        with pytest.raises(FmuError, match=r"cut\.fmu.*truncated"):
            read_fmu(fmu)


def test_a_damaged_member_is_named(tmp_path: Path) -> None:
    whole = bytearray(build("plants.ball_screw.two_mass").read_bytes())
    with zipfile.ZipFile(build("plants.ball_screw.two_mass")) as file:
        info = file.getinfo("modelDescription.xml")
    begin = info.header_offset + 60
    whole[begin : begin + 40] = bytes(40)
    fmu = tmp_path / "damaged.fmu"
    fmu.write_bytes(whole)
    with pytest.raises(FmuError, match=r"modelDescription\.xml cannot be read"):
        read_fmu(fmu)


def test_an_archive_without_a_description_is_no_fmu(tmp_path: Path) -> None:
    with pytest.raises(FmuError, match=r"has no modelDescription\.xml"):
        read_fmu(archive(tmp_path / "plain.fmu", "readme.txt"))


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(FmuError, match=r"nothing\.fmu: no such file"):
        read_fmu(tmp_path / "nothing.fmu")


def test_what_was_unpacked_is_deleted() -> None:
    with unpacked(build("plants.ball_screw.two_mass")) as folder:
        assert (folder / "modelDescription.xml").is_file()
    assert not folder.exists()

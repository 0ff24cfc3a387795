"""The cache and the refusals in front of every FMU."""

import errno
import subprocess
import sys
import zipfile
from fractions import Fraction
from pathlib import Path

import fmpy
import fmpy.validation
import pytest
from fmpy import read_model_description

from fmus.archive import content_digest
from fmus.build import BuildError, build, load_model
from fmus.cache import cache_folder

MODELS = Path(__file__).parent / "small_models"
PI = str(MODELS / "pi.py")
HEADERS = {
    "linux64": b"\x7fELF\x02\x01",
    "x86_64-linux": b"\x7fELF\x02\x01",
    "aarch64-linux": b"\x7fELF\x02\x01",
    "win64": b"MZ",
    "x86_64-windows": b"MZ",
    "darwin64": b"\xca\xfe\xba\xbe",
    "x86_64-darwin": b"\xcf\xfa\xed\xfe\x07\x00\x00\x01",
    "aarch64-darwin": b"\xcf\xfa\xed\xfe\x0c\x00\x00\x01",
}
ALL = ("linux-x86_64", "linux-aarch64", "windows-x86_64", "macos-x86_64", "macos-arm64")
AS_FMI_WRITES = {
    2: ("linux64", "aarch64-linux", "win64", "darwin64"),
    3: (
        *("x86_64-linux", "aarch64-linux", "x86_64-windows"),
        *("x86_64-darwin", "aarch64-darwin"),
    ),
}


def copied(tmp_path, name="pi", **replaced):
    source = (MODELS / f"{name}.py").read_text()
    for old, new in replaced.values():
        assert old in source
        source = source.replace(old, new)
    (tmp_path / f"{name}.py").write_text(source)
    return str(tmp_path / f"{name}.py")


def test_a_built_fmu_is_taken_from_the_cache(monkeypatch):
    first = build(PI)
    before = first.stat().st_mtime_ns
    monkeypatch.setattr("fmus.package.subject_of", None)
    assert build(PI) == first
    assert first.stat().st_mtime_ns == before


def test_a_warm_build_imports_neither_model_nor_tools():
    build("plants.ball_screw.two_mass")
    heavy = (
        "('casadi', 'lxml', 'pint', 'pythonfmu', 'fmpy', 'plants.ball_screw.two_mass')"
    )
    code = (
        "import sys; from fmus.build import build; build('plants.ball_screw.two_mass');"
        f"print([m for m in {heavy} if m in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "[]"


def test_two_processes_may_build_the_same_fmu_at_once(tmp_path):
    path = copied(tmp_path, K=("= 0.5", "= 0.625"))
    code = f"from fmus.build import build; print(build({path!r}))"
    runs = [
        subprocess.Popen(
            [sys.executable, "-c", code], stdout=subprocess.PIPE, text=True
        )
        for _ in range(2)
    ]
    told = {run.communicate()[0].strip() for run in runs}
    assert [run.returncode for run in runs] == [0, 0]
    (fmu,) = told
    assert fmpy.validation.validate_fmu(fmu) == []
    assert not list((cache_folder() / "fmus").glob(".building-*"))


@pytest.mark.parametrize(("kind", "fmi"), [("native", 2), ("native", 3), ("python", 2)])
def test_builds_in_different_folders_have_equal_contents(
    tmp_path, monkeypatch, kind, fmi
):
    digests = set()
    for name in ("here", "there and elsewhere"):
        monkeypatch.setenv("FEEDDRIVE_CACHE", str(tmp_path / name / "cache"))
        (tmp_path / name).mkdir()
        model = copied(tmp_path / name)
        fmu = build(model, kind=kind, fmi=fmi, folder=tmp_path / name / "out")
        assert fmu == tmp_path / name / "out" / "SmallPI.fmu"
        digests.add(content_digest(fmu))
    assert len(digests) == 1


def test_both_versions_of_fmi_share_one_binary_and_token():
    two, three = build(PI), build(PI, fmi=3)
    tokens = {read_model_description(str(fmu)).guid for fmu in (two, three)}
    assert len(tokens) == 1
    libraries = set()
    for fmu in (two, three):
        with zipfile.ZipFile(fmu) as archive:
            names = [n for n in archive.namelist() if n.startswith("binaries/")]
            libraries |= {archive.read(n) for n in names}
    assert len(libraries) == 1


def test_an_edited_model_is_built_anew_in_the_same_process(tmp_path):
    path = copied(tmp_path)
    build(path)
    copied(tmp_path, K=("= 0.5", "= 0.7"))
    variables = read_model_description(str(build(path))).modelVariables
    assert next(v.start for v in variables if v.name == "K_p") == "0.7"
    assert load_model(path).parameters.K_p == 0.7


def test_model_files_of_one_name_in_two_folders_are_not_mixed_up(tmp_path):
    paths = []
    for gain in ("0.1", "0.2"):
        folder = tmp_path / gain
        folder.mkdir()
        (folder / "gains.py").write_text(f"K_p = {gain}\n")
        paths.append(copied(folder, K=("= 0.5", "= gains.K_p")))
        file = folder / "pi.py"
        file.write_text(
            file.read_text().replace("import numpy", "import gains\nimport numpy")
        )
    assert [load_model(p).parameters.K_p for p in [*paths, paths[0]]] == [0.1, 0.2, 0.1]


@pytest.mark.parametrize(("kind", "fmi"), [("native", 2), ("native", 3), ("python", 2)])
def test_the_period_is_baked_in(kind, fmi):
    fmu = str(build(PI, kind=kind, fmi=fmi, period=Fraction(1, 3000)))
    description = read_model_description(fmu)
    (T_s,) = (v for v in description.modelVariables if v.name == "T_s")
    assert float(T_s.start) == 1 / 3000
    assert float(description.defaultExperiment.stepSize) == 1 / 3000
    result = fmpy.simulate_fmu(
        fmu, stop_time=1 / 1000, output_interval=1 / 3000, start_values={"r": 0.1}
    )
    T_i = 20.0 / 3000
    assert result["u"] == pytest.approx(
        [0.05 + 0.1 * T_i * max(0, k - 1) for k in range(4)]
    )


def test_one_model_has_the_right_binary_for_each_of_five_platforms():
    for fmi, expected in ((2, 4), (3, 5)):
        fmu = build(PI, fmi=fmi, platforms=ALL)
        # as FMI writes them they are the same, found in the cache
        assert build(PI, fmi=fmi, platforms=AS_FMI_WRITES[fmi]) == fmu
        with zipfile.ZipFile(fmu) as archive:
            names = [n for n in archive.namelist() if n.startswith("binaries/")]
            assert len(names) == expected
            for name in names:
                head = archive.read(name)[:4096]
                assert head.startswith(HEADERS[name.split("/")[1]]), name
                if name.startswith(("binaries/linux64", "binaries/x86_64-linux")):
                    assert head[18] == 0x3E
                if name.startswith("binaries/aarch64-linux"):
                    assert head[18] == 0xB7
                if head.startswith(b"MZ"):
                    start = int.from_bytes(head[0x3C:0x40], "little")
                    assert head[start : start + 6] == b"PE\0\0\x64\x86"


def test_an_archive_holds_what_a_reader_needs():
    with zipfile.ZipFile(build(PI)) as two, zipfile.ZipFile(build(PI, fmi=3)) as three:
        assert b"MIT License" in two.read("documentation/license.txt")
        assert b"MIT License" in three.read("documentation/licenses/license.txt")
        page = two.read("documentation/index.html").decode()
        assert "q⁺ = q + T_s K_i" in page
        assert "N.m.s/rad" in page
        files = set(two.namelist())
    compiled = [
        configuration.sourceFileSets[0].sourceFiles
        for fmu in (build(PI), build(PI, fmi=3))
        for configuration in read_model_description(str(fmu)).buildConfigurations
    ]
    assert compiled[0] == compiled[1]
    assert {f"sources/{name}" for name in compiled[0]} <= files


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_sources_inside_compile_into_the_same_model(tmp_path, fmi):
    fmu = build(str(MODELS / "spring_mass.py"), fmi=fmi)
    fmpy.extract(str(fmu), str(tmp_path))
    (binary,) = (tmp_path / "binaries").rglob("*.*")
    shipped = fmpy.simulate_fmu(str(tmp_path), stop_time=0.01)
    binary.unlink()
    configuration = read_model_description(str(tmp_path)).buildConfigurations[0]
    names = configuration.sourceFileSets[0].sourceFiles
    flags = [
        "-shared",
        "-fPIC",
        "-std=c99",
        "-O2",
        "-ffp-contract=off",
        "-o",
        str(binary),
    ]
    command = [sys.executable, "-m", "ziglang", "cc", *flags, *names, "-lm"]
    subprocess.run(command, cwd=tmp_path / "sources", check=True)
    compiled = fmpy.simulate_fmu(str(tmp_path), stop_time=0.01)
    assert len(shipped) > 10
    assert (shipped == compiled).all()


@pytest.mark.parametrize(
    ("options", "complaint"),
    [
        ({"module": "plants.nowhere"}, "there is no module 'plants.nowhere'"),
        ({"module": "/nowhere/nope.py"}, "^no such file"),
        ({"module": "fmus.table"}, "fmus.table has no model"),
        ({"module": PI, "period": Fraction(0)}, "period of 0 s is not positive"),
        ({"module": PI, "period": Fraction(-1, 2)}, "period of -1/2 s is not positive"),
        ({"module": PI, "kind": "python", "fmi": 3}, "Python FMUs are FMI 2 only"),
        ({"module": PI, "fmi": 1}, "FMI 1 is not written here"),
        ({"module": PI, "kind": "java"}, "there is no kind 'java'"),
        (
            {"module": PI, "platforms": ["beos"]},
            "cannot be built for beos: choose from",
        ),
        ({"module": PI, "platforms": []}, "for no platform: choose from linux"),
        (
            {"module": PI, "kind": "python", "platforms": ["macos-arm64"]},
            "python FMU cannot be built for macos-arm64",
        ),
        (
            {"module": str(MODELS / "late.py"), "period": Fraction(1, 2)},
            "Late is continuous and has no period",
        ),
    ],
)
def test_options_that_do_not_go_together_are_refused(options, complaint):
    with pytest.raises(BuildError, match=complaint):
        build(**options)


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("u.r - u.y", "u.r - u.z", r"pi.py:48: e = u.r - u.z: .*no attribute 'z'"),
        (
            "    e = u",
            "    if u.r > 0: pass\n    e = u",
            r"pi.py:48: if u.r > 0: pass: .*np.where",
        ),
        (
            "    e = u",
            "    return None\n    e = u",
            r"pi.py:\d+: step returned nothing; .*return State",
        ),
        ("State(q)", "Parameters(q)", r"step returned Parameters.*return State"),
        ("p: Parameters, T_s: float)", "p: Parameters)", r"prepare: .*with .p, T_s"),
        ("class State(NamedTuple)", "class State", r"State, which is no NamedTuple"),
        ("step, State(),", "step, State,", r"is the class State; give .* State\(\)"),
        ("Fraction(1, 2000)", "0.0005", r"write it .* period=Fraction"),
        ("np.fabs(v)", "float(v)", "cannot be traced: "),
        ("e = u.r - u.y", "e = u.r - (u.y", r"pi.py:48: '\(' was never closed"),
        ('"SmallPI"', '"Small PI"', "'Small PI' is no C identifier"),
        (
            "Fraction(1, 2000)",
            "Fraction(-1, 2000)",
            r"Fraction\(-1, 2000\) is no",
        ),
        ("import numpy as np", "import numpy as np\n1/0", r"pi.py:\d+: 1/0: division"),
        (
            "] = 1.0",
            "] = np.ones(65)",
            "u_max has 65 elements; over 64, declare it Var",
        ),
        (
            "v = p.K_p * e + x.q",
            "v = np.sum(np.outer([1., 2.], [3., 4.]) * np.hstack([e, e])) + x.q",
            "pi.py:|NumPy",
        ),
    ],
)
def test_a_model_that_cannot_become_an_fmu_is_refused_with_its_line(
    tmp_path, old, new, complaint
):
    with pytest.raises(BuildError, match=complaint):
        build(copied(tmp_path, change=(old, new)))


def test_a_matrix_that_casadi_broadcasts_otherwise_is_refused(tmp_path):
    path = copied(
        tmp_path,
        "matrices",
        change=("p.gains.A @ x.bank.w", "np.sum(p.gains.A * x.bank.w, axis=1)"),
    )
    with pytest.raises(BuildError, match=r"state.bank.w\[1\] = .*write A @ x"):
        build(path)


def test_a_model_file_called_like_a_module_of_python_is_refused(tmp_path):
    path = tmp_path / "signal.py"
    path.write_text((MODELS / "pi.py").read_text())
    with pytest.raises(BuildError, match="rename it"):
        build(str(path))


def test_a_missing_tool_is_named(monkeypatch):
    from fmus import build as front

    monkeypatch.setattr(front, "TOOLS", {"native": ("no-such-compiler",)})
    with pytest.raises(BuildError, match=r"no-such-compiler is needed .*pip install"):
        build(PI)


def test_a_full_disk_is_named_with_the_file_that_was_asked_for(monkeypatch, tmp_path):
    def full(source, target):
        Path(target).write_bytes(b"")
        raise OSError(errno.ENOSPC, "No space left on device", str(source))

    monkeypatch.setattr("fmus.build.shutil.copyfile", full)
    with pytest.raises(OSError, match="No space") as refusal:
        build(PI, folder=tmp_path / "out")
    assert refusal.value.filename == str(tmp_path / "out" / "SmallPI.fmu")
    assert not list((tmp_path / "out").iterdir())


def test_a_model_whose_numbers_hold_for_one_period_is_built_for_no_other(tmp_path):
    path = copied(tmp_path, one=("2000), prepare", "2000), prepare, period_fixed=True"))
    build(path, period=load_model(path).period)
    with pytest.raises(BuildError, match="sampled every 1/2000 s alone"):
        build(path, period=Fraction(1, 3000))

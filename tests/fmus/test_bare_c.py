"""Plain C of sampled models: the FMU's bits, also on a Cortex-M."""

import re
import subprocess
from pathlib import Path

import fmpy
import numpy as np
import pytest
from modules import MODULES
from subject import Instance, subject
from tools import needed

from fmus.build import BuildError, build, build_c

BOARD = Path(__file__).parents[1] / "support" / "cortex_m"
CORTEX = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16"]
STRICT = ["-std=c99", "-Wall", "-Wextra", "-pedantic-errors", "-Werror"]
SAMPLED = [m for m in MODULES if not subject(m).continuous]
REPRESENTATIVES = (
    "controllers.ball_screw.mc_ppc",
    "controllers.interfaces.csp",
    "controllers.leadscrew.gain_stairs",
    "controllers.references.trajectory",
)
FLOAT = 1e-3  # of the largest output
# words of 32 bits, and draws from residues of 26 bits
NEEDS_DOUBLE = {
    *(f"controllers.interfaces.{name}" for name in ("csp", "csv", "telegram_105")),
    *("plants.ball_screw.scales", "plants.gantry.scales", "plants.sensors.noise"),
    "plants.disturbances.noise",
}


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    if "sampled" in metafunc.fixturenames:
        everything = metafunc.config.getoption("--every-form")
        metafunc.parametrize("sampled", SAMPLED if everything else REPRESENTATIVES)


def table(text: str, name: str) -> np.ndarray:
    """Return a table of the test vector."""
    body = re.search(rf"{name}\[\d+\]\[\d+\] = {{\n(.*?)}};", text, re.DOTALL)
    assert body
    rows = re.findall(r"{(.*)}", body[1])
    return np.array([[float(x) for x in row.split(",")] for row in rows])


def tell(command: list[str | Path], folder: Path) -> tuple[int, float]:
    """Return how many values differ, and the largest error."""
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    found = re.fullmatch(r"(\d+) differ, largest error (\S+)\s*", done.stdout)
    assert found, done.stdout + done.stderr
    return int(found[1]), float(found[2])


def static_data(file: Path) -> int:
    """Return the bytes of memory that an object file takes besides its code."""
    done = subprocess.run(
        ["arm-none-eabi-size", file], check=True, capture_output=True, text=True
    )
    _, data, bss, *_ = done.stdout.split("\n")[1].split()
    return int(data) + int(bss)


def test_the_test_vector_is_that_of_the_fmu_bit_for_bit(sampled, tmp_path):
    needed("gcc")
    s = subject(sampled)
    folder = build_c(sampled, folder=tmp_path)
    text = (folder / f"{s.model.name}_test.c").read_text()
    inputs, outputs = table(text, "inputs"), table(text, "outputs")
    instance = Instance(build(sampled), 2, tmp_path / "fmu", s.layout)
    instance.slave.exitInitializationMode()
    for k, (u, y) in enumerate(zip(inputs, outputs, strict=True)):
        instance.set("input", u)
        instance.slave.doStep(k * s.h, s.h)
        assert np.array_equal(instance.get("output"), y)
    instance.close()
    sources = sorted(folder.glob("*.c"))
    for command in (["gcc", *STRICT], ["gcc", "-O3", *STRICT]):
        subprocess.run([*command, *sources, "-o", folder / "t", "-lm"], check=True)
        assert tell([folder / "t"], folder) == (0, 0.0)


@pytest.mark.parametrize("real", ["double", "float"])
def test_a_cortex_m_steps_to_the_same_bits_or_with_a_small_error(
    sampled, real, tmp_path
):
    needed("arm-none-eabi-gcc", "arm-none-eabi-size", "qemu-system-arm")
    if real == "float" and sampled in NEEDS_DOUBLE:
        with pytest.raises(BuildError, match=r"\d, which is no number of single prec"):
            build_c(sampled, folder=tmp_path, real=real)
        return
    folder = build_c(sampled, folder=tmp_path, real=real)
    command = ["arm-none-eabi-gcc", "-O2", *STRICT, *CORTEX]
    if real == "float":
        command.append("-Wdouble-promotion")
        for file in folder.glob("*_test.c"):  # which compares with doubles
            file.write_text(
                '#pragma GCC diagnostic ignored "-Wdouble-promotion"\n'
                + file.read_text()
            )
    sources = [*sorted(folder.glob("*.c")), BOARD / "start.c"]
    script = ["--specs=rdimon.specs", "-T", BOARD / "mps2.ld"]
    start = [s for s in sources if s.name != "start.c"]
    objects = []
    for source in start:
        target = folder / f"{source.stem}.o"
        subprocess.run([*command, "-c", source, "-o", target], check=True)
        objects.append(target)
    assert static_data(folder / f"{subject(sampled).model.name}.o") == 0
    link = ["arm-none-eabi-gcc", *CORTEX, *script, *objects, BOARD / "start.c"]
    subprocess.run([*link, "-o", folder / "t.elf", "-lm"], check=True)
    board = ["qemu-system-arm", "-M", "mps2-an386", "-nographic", "-semihosting"]
    differing, error = tell([*board, "-kernel", folder / "t.elf"], folder)
    if real == "double":
        assert (differing, error) == (0, 0.0)
    else:
        assert error < FLOAT


def test_plain_c_of_a_plant_and_of_names_that_meet_is_refused(tmp_path):
    with pytest.raises(BuildError, match=r"continuous.*build an FMU"):
        build_c("plants.xy_table.axis", folder=tmp_path)
    with pytest.raises(BuildError, match="double, float"):
        build_c("controllers.xy_table.np_pi", folder=tmp_path, real="half")


def test_a_float_is_cut_in_two_as_a_float_and_counts_as_far_as_it_can(tmp_path):
    folder = build_c("controllers.references.trajectory", folder=tmp_path, real="float")
    code = (folder / f"{folder.name}.c").read_text()
    assert "4097.f" in code
    assert "134217729" not in code
    assert "16777216, after 838.9 s" in (folder / f"{folder.name}.h").read_text()


def test_a_start_value_that_a_float_makes_zero_or_infinite_is_refused(tmp_path):
    for value in (1e-50, -1e300):
        with pytest.raises(BuildError, match=r"starts k_v with .*single precision"):
            build_c(
                "controllers.xy_table.np_pi",
                values={"k_v": value},
                folder=tmp_path,
                real="float",
            )


def test_designed_values_travel_in_the_fmu_and_in_plain_c(tmp_path):
    values = {"K_p1": 40.0, "K_i1": 2.0}
    fmu = build("controllers.xy_table.np_pi", values={"k_v": 7.5}, origin=" of a test")
    starts = {
        v.name: v.start for v in fmpy.read_model_description(str(fmu)).modelVariables
    }
    assert float(starts["k_v"]) == 7.5
    with pytest.raises(BuildError, match="has no parameter, input or state K_i1"):
        build("controllers.leadscrew.nctf", values=values)
    folder = build_c("controllers.xy_table.np_pi", values={"k_v": 7.5}, folder=tmp_path)
    assert "7.5" in (folder / f"{folder.name}.c").read_text()

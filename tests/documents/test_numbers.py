"""The numbers of the pages *Assess one wall* and *The damper in your program*, computed by other ways; its listings."""

import re
import shutil
import subprocess
from math import copysign

import numpy as np
import pytest
from page_blocks import read
from pages import assert_stated, read_full
from repository import ROOT
from scipy.interpolate import CubicSpline

import rockdamp as rd
from rockdamp.constants import PRESETS, SMALL_RELEASE_OVERSTATES
from rockdamp.mechanics.dampers import half_cycle_loss
from rockdamp.mechanics.wall import SORRENTINO_RATIO
from rockdamp.solvers.exact import exact_history

DAMPER, WALL = "docs/howto/damper-in-your-program.md", "docs/howto/one-wall.md"
CURVE = rd.TrilinearCurve(0.04, 0.85)
W1, E, WIDTH = float(CURVE.initial_frequency), 0.85, 0.2
DELTA = -np.log(E)
SHORT = DELTA * (1 + 0.4 * WIDTH**2 - 0.097 * WIDTH**4 - 0.043 * DELTA**2)
# The damper of the kernel that has the delta' of the listings.
SAME = rd.Damping("BAND", half_cycle_loss(SHORT, WIDTH) / np.pi, width=WIDTH)


def table(page, first_cell):
    """Rows of the page's table whose head begins with this cell."""
    rows = read(page).split(f"| {first_cell} |")[1].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def pulse(tau):
    return 2 * np.sin(np.pi * tau / 0.7) if tau < 0.7 - 1e-9 else 0.0


def python_listing(h, steps, *, lag=False):
    """Return x at each step under the pulse, by the page's own lines in explicit Newmark."""
    names = {}
    exec(
        re.findall(r"^```python\n(.*?)^```$", read(DAMPER), flags=re.MULTILINE | re.DOTALL)[0],
        names,
    )
    x, v, a, found = 0.0, 0.0, 0.0, [0.0]
    for n in range(1, steps + 1):
        half, at = v + h / 2 * a, (x, v)
        x, expected = x + h * v + h * h / 2 * a, v + h * a
        c = names["coefficient"](*(at if lag else (x, expected)), 1.0, E, W1)
        z = abs(x)
        a = (pulse(n * h) - copysign(max(0.0, min(0.85 / 0.04 * z, 0.85, 1 - z)), x) - c * half) / (
            1 + c * h / 2
        )
        v = half + h / 2 * a
        found.append(x)
    return np.array(found)


@pytest.fixture(scope="module")
def kernel():
    """x at each step of 0.002 up to tau = 4."""
    load = [pulse(0.002 * n) for n in range(2001)]
    return rd.simulate(CURVE, SAME, load=rd.Load(load, 1.0, 0.002)).displacement


def test_the_python_listing_is_the_kernel_s_damper(kernel):
    np.testing.assert_allclose(python_listing(0.002, 2000), kernel, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("compiler", "source", "libraries"), [("cc", "band.c", ["-lm"]), ("gfortran", "band.f90", [])]
)
def test_the_files_in_other_languages_are_the_kernel_s_damper(
    kernel, compiler, source, libraries, tmp_path
):
    if not shutil.which(compiler):
        pytest.skip(f"there is no {compiler}")
    command = [
        compiler,
        "-O2",
        "-Wall",
        "-Werror",
        str(ROOT / "examples" / source),
        "-o",
        "band",
        *libraries,
    ]
    subprocess.run(command, check=True, cwd=tmp_path)  # Fortran writes its module beside
    printed = subprocess.run([tmp_path / "band"], check=True, capture_output=True, text=True).stdout
    np.testing.assert_allclose(
        np.array(printed.split(), dtype=float), [kernel[:1000].max(), kernel[-1]], atol=1e-12
    )


def test_the_number_to_check():
    load = 2 * np.sin(np.pi * np.linspace(0, 1, 701))
    for model, peak in (("CR", 0.400), ("BAND", 0.397)):
        damping = rd.Damping.from_restitution(E, model)
        run = exact_history(CURVE, damping, [2.0], load=load, sampling=0.001)
        assert run.turning_displacement[0] == pytest.approx(peak, abs=5e-4)


def test_the_step_that_the_damper_needs_and_what_a_lag_costs():
    """The first three peaks at h = c/4 and c/16, of C at the end of the step and at its start."""

    def peaks(parts, **how):
        h = WIDTH / W1 / parts
        x = python_listing(h, round(5 / h), **how)
        turns = np.flatnonzero((x[1:-1] - x[:-2]) * (x[2:] - x[1:-1]) < 0)
        return x[turns[:3] + 1]

    limit = peaks(320)
    assert np.abs(peaks(4) / limit - 1).max() == pytest.approx(0.004, abs=5e-4)
    assert np.abs(peaks(16) / limit - 1).max() < 1e-4
    for parts, late in ((4, 0.0063), (16, 0.0015)):
        assert peaks(parts, lag=True)[2] / limit[2] - 1 == pytest.approx(late, rel=0.05)


def test_what_a_damping_ratio_stands_for():
    rows = table(DAMPER, "ξ [%]")
    xi = np.array([float(row[0]) for row in rows]) / 100
    for column, x in (
        (1, xi / np.sqrt(1 - xi**2)),
        (2, xi),
    ):  # BAND has the formula of the orders above 0
        assert [row[column] for row in rows] == [f"{e:.4f}" for e in np.exp(-np.pi * x)]
    every_e = np.linspace(0.5, 0.98, 17)
    matched = rd.equivalent(every_e, CURVE)
    for column, model in enumerate(("CDC", "CDR", "SDR"), start=3):
        ratio = np.array([one["damping_ratio"] for one in matched if one["damping_model"] == model])
        e = CubicSpline(ratio[::-1], every_e[::-1])(xi)
        np.testing.assert_allclose(
            [float(row[column]) for row in rows], e, atol=0.002
        )  # CDC's are rough in e


def test_published_restitutions():
    housner = 1 - 1.5 / (1 + 5**2)
    wall = rd.Wall(thickness=3 / 20, height=3.0, hinge_ratio=0.5)
    expected = [0.852, 0.9 * float(wall.restitution_rigid), 0.95 * housner, 0.67 * housner]
    for (e, xi, *_), value in zip(table(DAMPER, "measured e"), expected, strict=True):
        assert float(e) == pytest.approx(value, abs=6e-4)
        assert xi == f"{100 * float(rd.Damping.from_restitution(float(e), 'BAND').value):.1f}"


def test_presets():
    assert {row[0]: row[1:3] for row in table(WALL, "`--preset`")} == {
        f"`{name}`": [f"{a1:.2f}", f"{b1:.2f}"] for name, (b1, a1) in PRESETS.items()
    }


def test_measured_restitutions_over_the_analytical_one():
    """Those that the paper quotes: mean, lowest and highest, of a wall of slenderness 27 with its hinge at 0.57."""
    analytical = float(
        rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57).restitution_rigid
    )
    assert SORRENTINO_RATIO == 0.90
    assert_stated(
        WALL,
        r"tests of walls gave ([\d.]+) \(([\d.]+) to ([\d.]+)\)",
        *(e / analytical for e in (0.852, 0.84, 0.90)),
    )


def test_a_gable_beside_a_rectangle():
    """About the base: a rectangle has its centre at h/2 and I = m h^2/3, a triangle at h/3 and m h^2/6."""
    rectangle, gable = (1 / 2, 1 / 3), (1 / 3, 1 / 6)
    onset = [0.5 / centre for centre, _ in (rectangle, gable)]
    # p u_ins over the excitation factor, of unit height, thickness, mass and gravity
    velocity = [0.5 / centre * np.sqrt(inertia / centre) for centre, inertia in (rectangle, gable)]
    words = r"rock at ([\d.]+) times the acceleration of a rectangle and topples at ([\d.]+) times the velocity"
    assert_stated(WALL, words, onset[1] / onset[0], velocity[1] / velocity[0])


def test_small_releases_overstate_the_intensity():
    """A test keeps the constant to its table in docs/earthquakes.md."""
    overstated = re.findall(r"\d+", SMALL_RELEASE_OVERSTATES)[:2]
    assert_stated(
        WALL, r"overstates the median intensity by (\d+) to (\d+) %", *map(float, overstated)
    )


def test_force_at_the_crossing():
    force = read_full("order")["crossing_force"].sel(wall="paper", restitution=E)
    words = r"([\d.]+) F0 at the crossing with 0.2, ([\d.]+) F0 with 0.4"
    assert_stated(
        DAMPER, words, *(float(force.sel(damper=damper)) for damper in ("BAND0.2", "BAND0.4"))
    )


def test_floors_lower_every_wall():
    supports = read_full("supports").drop_sel(wall="all")
    floors = supports.isel(
        assumption=supports["diaphragm_period"].isin([0.2, 0.3, 0.4, 0.6]).values
    )
    assert floors.sizes["assumption"] == 4 and (floors["median_intensity_ratio"] < 1).all()

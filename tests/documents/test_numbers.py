"""Numbers of *Assess one wall* and *The damper in your program* by other ways, and listings."""

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
from rockdamp.mechanics.half_cycle_loss import half_cycle_loss
from rockdamp.mechanics.wall import SORRENTINO_RATIO
from rockdamp.solvers.exact import exact_history

DAMPER = "docs/howto/damper-in-your-program.md"
WALL = "docs/howto/one-wall.md"
CURVE = rd.TrilinearCurve(0.04, 0.85)
W1 = float(CURVE.initial_frequency)
E = 0.85
WIDTH = 0.2
DELTA = -np.log(E)
SHORT = DELTA * (1 + 0.4 * WIDTH**2 - 0.097 * WIDTH**4 - 0.043 * DELTA**2)
# The damper of the kernel that has the delta' of the listings.
SAME = rd.Damping("BAND", half_cycle_loss(SHORT, WIDTH) / np.pi, width=WIDTH)


def table(page, first_cell):
    """Return the rows of a page's table whose head begins with a cell."""
    rows = read(page).split(f"| {first_cell} |")[1].split("\n\n")[0].splitlines()[2:]
    return [[cell.strip() for cell in row.strip("|").split("|")] for row in rows]


def pulse(tau):
    return 2 * np.sin(np.pi * tau / 0.7) if tau < 0.7 - 1e-9 else 0.0


def python_listing(h, steps, *, lag=False):
    """Return x at each step under the pulse, by the page's own lines in explicit Newmark."""
    names = {}
    listing = re.search(r"^```python\n(.*?)^```$", read(DAMPER), re.MULTILINE | re.DOTALL)
    exec(listing[1], names)
    x = 0.0
    v = 0.0
    a = 0.0
    displacements = [x]
    for n in range(1, steps + 1):
        start = (x, v)
        v_half = v + h / 2 * a
        x = x + h * v_half
        end = (x, v + h * a)
        c = names["coefficient"](*(start if lag else end), 1.0, E, W1)
        z = abs(x)
        force = copysign(max(0.0, min(0.85 / 0.04 * z, 0.85, 1 - z)), x)
        a = (pulse(n * h) - force - c * v_half) / (1 + c * h / 2)
        v = v_half + h / 2 * a
        displacements.append(x)
    return np.array(displacements)


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
    options = ["-O2", "-Wall", "-Werror", "-o", "band"]
    command = [compiler, *options, str(ROOT / "examples" / source), *libraries]
    subprocess.run(command, check=True, cwd=tmp_path)  # Fortran writes its module there too
    result = subprocess.run([tmp_path / "band"], check=True, capture_output=True, text=True)
    numbers = np.array(result.stdout.split(), dtype=float)
    np.testing.assert_allclose(numbers, [kernel[:1000].max(), kernel[-1]], atol=1e-12)


@pytest.mark.parametrize(("model", "peak"), [("CR", 0.400), ("BAND", 0.397)])
def test_the_number_to_check(model, peak):
    load = 2 * np.sin(np.pi * np.linspace(0, 1, 701))
    damping = rd.Damping.from_restitution(E, model)
    history = exact_history(CURVE, damping, [2.0], load=load, sampling=0.001)
    assert history.turning_displacement[0] == pytest.approx(peak, abs=5e-4)


def listing_peaks(parts, lag=False):
    """Return the first three peaks at steps of a part of the band."""
    h = WIDTH / W1 / parts
    x = python_listing(h, round(5 / h), lag=lag)
    turns = np.flatnonzero((x[1:-1] - x[:-2]) * (x[2:] - x[1:-1]) < 0)
    return x[turns[:3] + 1]


@pytest.fixture(scope="module")
def limit():
    return listing_peaks(320)


def test_step_that_the_damper_needs(limit):
    assert np.abs(listing_peaks(4) / limit - 1).max() == pytest.approx(0.004, abs=5e-4)
    assert np.abs(listing_peaks(16) / limit - 1).max() < 1e-4


@pytest.mark.parametrize(("parts", "error"), [(4, 0.0063), (16, 0.0015)])
def test_coefficient_of_the_last_step_costs_accuracy(limit, parts, error):
    """C is taken at the start of the step and not at its end."""
    peaks = listing_peaks(parts, lag=True)
    assert peaks[2] / limit[2] - 1 == pytest.approx(error, rel=0.05)


@pytest.fixture(scope="module")
def ratio_columns():
    """The columns of the table of damping ratios: xi, then e of each damper as text."""
    xi, *columns = zip(*table(DAMPER, "ξ [%]"), strict=True)
    return np.array(xi, dtype=float) / 100, columns


def test_e_of_a_damping_ratio_of_ecd_and_band(ratio_columns):
    """BAND has the formula of the orders above 0."""
    xi, (ecd, band, *_) = ratio_columns
    assert list(ecd) == [f"{e:.4f}" for e in np.exp(-np.pi * xi / np.sqrt(1 - xi**2))]
    assert list(band) == [f"{e:.4f}" for e in np.exp(-np.pi * xi)]


@pytest.mark.parametrize(("column", "model"), [(2, "CDC"), (3, "CDR"), (4, "SDR")])
def test_e_of_a_damping_ratio_of_the_paper(ratio_columns, column, model):
    xi, columns = ratio_columns
    restitution = np.linspace(0.5, 0.98, 17)
    rows = rd.equivalent(restitution, CURVE)
    ratios = [row["damping_ratio"] for row in rows if row["damping_model"] == model]
    expected = CubicSpline(ratios[::-1], restitution[::-1])(xi)
    # CDC's are rough in e.
    np.testing.assert_allclose(np.array(columns[column], dtype=float), expected, atol=0.002)


def test_published_restitutions():
    housner = 1 - 1.5 / (1 + 5**2)
    wall = rd.Wall(thickness=3 / 20, height=3.0, hinge_ratio=0.5)
    expected = [0.852, 0.9 * float(wall.restitution_rigid), 0.95 * housner, 0.67 * housner]
    for (e, xi, *_), value in zip(table(DAMPER, "measured e"), expected, strict=True):
        assert float(e) == pytest.approx(value, abs=6e-4)
        damping = rd.Damping.from_restitution(float(e), "BAND")
        assert xi == f"{100 * float(damping.value):.1f}"


def test_presets():
    rows = {row[0]: row[1:3] for row in table(WALL, "`--preset`")}
    expected = {}
    for name, (b1, a1) in PRESETS.items():
        expected[f"`{name}`"] = [f"{a1:.2f}", f"{b1:.2f}"]
    assert rows == expected


def test_measured_restitutions_over_the_analytical_one():
    """The paper quotes the mean, lowest and highest of a wall of slenderness 27, hinged at 0.57."""
    wall = rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57)
    ratios = np.array([0.852, 0.84, 0.90]) / float(wall.restitution_rigid)
    assert SORRENTINO_RATIO == 0.90
    assert_stated(WALL, r"tests of walls gave ([\d.]+) \(([\d.]+) to ([\d.]+)\)", *ratios)


def test_gable_beside_a_rectangle():
    """About the base: the centre is at h/2 or h/3 and I is m h^2/3 or m h^2/6."""
    centre = np.array([1 / 2, 1 / 3])
    inertia = np.array([1 / 3, 1 / 6])
    onset = 0.5 / centre
    # p u_ins over the excitation factor, of unit height, thickness, mass and gravity.
    velocity = onset * np.sqrt(inertia / centre)
    words = (
        r"rock at ([\d.]+) times the acceleration of a rectangle "
        r"and topples at ([\d.]+) times the velocity"
    )
    assert_stated(WALL, words, onset[1] / onset[0], velocity[1] / velocity[0])


def test_small_releases_overstate_the_intensity():
    """Another test compares the constant with its table in docs/earthquakes.md."""
    low, high = re.findall(r"\d+", SMALL_RELEASE_OVERSTATES)
    words = r"overstates the median collapse intensity by (\d+) to (\d+) %"
    assert_stated(WALL, words, float(low), float(high))


def test_force_at_the_crossing():
    force = read_full("order")["crossing_force"].sel(wall="paper", restitution=E)
    words = r"at the crossing: ([\d.]+) F0 with 0.2, ([\d.]+) F0 with 0.4"
    assert_stated(DAMPER, words, *force.sel(damper=["BAND0.2", "BAND0.4"]).values)


def test_floors_lower_every_wall():
    supports = read_full("supports").drop_sel(wall="all")
    is_floor = supports["diaphragm_period"].isin([0.2, 0.3, 0.4, 0.6]).values
    floors = supports.isel(assumption=is_floor)
    assert floors.sizes["assumption"] == 4
    assert (floors["median_intensity_ratio"] < 1).all()

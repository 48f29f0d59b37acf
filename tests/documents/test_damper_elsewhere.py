"""docs/howto/order-m-damper-elsewhere.md: its listings compiled and run, its numbers and its tables computed anew."""

import re
import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp
from exact_cases import cr_peaks
from order_m_motion import branches, of_restitution
from repository import ROOT
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import rockdamp as rd
from rockdamp.mechanics.damping.ecd import damping_ratio, log_decrement, normalisation
from rockdamp.solvers import event_driven
from rockdamp.vocabulary import RECOMMENDED_ORDER

PAGE = (ROOT / "docs/howto/order-m-damper-elsewhere.md").read_text(encoding="utf-8")
CURVE = rd.TrilinearCurve(0.04, 0.85)
ORDER, E = RECOMMENDED_ORDER, 0.85


def listing(language):
    (block,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    return block


def table(first_cell):
    """Rows of the page's table that begins with this cell."""
    lines = PAGE[PAGE.index(f"| {first_cell} |") :].split("\n\n")[0].splitlines()
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in [lines[0], *lines[2:]]]


def pulse(tau):
    return 2 * np.sin(np.pi * tau / 0.7) if tau < 0.7 else 0.0


TIMES, DECAY, PULSE, IMPACTS = np.array(table("tau")[1:], dtype=float).T
C_MAIN = """
#include <stdio.h>
#include <stdlib.h>
int main(int count, char **given) {
    double h = atof(given[1]), pi = acos(-1.0);
    for (int forced = 0; forced < 2; forced++) {
        double x = forced ? 0.0 : 0.5, v = 0.0, a = forced ? 0.0 : -0.5;
        for (long n = 1; n <= lround(8 / h); n++) {
            double tau = n * h;
            step(&x, &v, &a, forced && tau < 0.7 ? 2 * sin(pi * tau / 0.7) : 0.0, h);
            if (n % lround(0.5 / h) == 0) printf("%.9f\\n", x);
        }
    }
    return count != 2;
}
"""
FORTRAN_MAIN = """
program check
  use order_m_damper
  character(20) :: given
  real(dp) :: h, x, v, a, p
  integer :: forced
  integer(kind=8) :: n
  call get_command_argument(1, given)
  read (given, *) h
  do forced = 0, 1
    x = merge(0.0_dp, 0.5_dp, forced == 1); v = 0; a = -x
    do n = 1, nint(8/h, kind=8)
      p = 0
      if (forced == 1 .and. n*h < 0.7_dp) p = 2*sin(acos(-1.0_dp)*n*h/0.7_dp)
      call step(x, v, a, p, h)
      if (mod(n, nint(0.5_dp/h, kind=8)) == 0) print '(f14.9)', x
    end do
  end do
end program
"""


def of_python(h, source=None):
    names = {}
    exec(source or listing("python"), names)  # the page's own lines
    found = []
    for forced in (False, True):
        x, v, a = (0.0, 0.0, 0.0) if forced else (0.5, 0.0, -0.5)
        for n in range(1, round(8 / h) + 1):
            x, v, a = names["step"](x, v, a, pulse(n * h) if forced else 0.0, h)
            if n % round(0.5 / h) == 0:
                found.append(x)
    return np.reshape(found, (2, -1))


def of_compiler(name, language, ending, main, libraries, tmp_path, h):
    compiler = shutil.which(name)
    if not compiler:
        pytest.skip(f"there is no {name}")
    source, program = tmp_path / f"damper.{ending}", tmp_path / "damper"
    source.write_text(listing(language) + main, encoding="utf-8")
    command = [compiler, "-O2", "-Wall", "-Werror", str(source), "-o", str(program), *libraries]
    subprocess.run(command, check=True, cwd=tmp_path)  # Fortran writes its module beside
    printed = subprocess.run([str(program), str(h)], check=True, capture_output=True, text=True).stdout
    return np.reshape(np.array(printed.split(), dtype=float), (2, -1))


def of_c(h, tmp_path):
    return of_compiler("cc", "c", "c", C_MAIN, ["-lm"], tmp_path, h)


def of_fortran(h, tmp_path):
    return of_compiler("gfortran", "fortran", "f90", FORTRAN_MAIN, [], tmp_path, h)


def away(found):
    """Largest distance from the page's numbers."""
    rows = np.rint(TIMES / 0.5).astype(int) - 1
    return np.abs(found[:, rows] - [DECAY, PULSE]).max()


@pytest.fixture(scope="module")
def python():
    return of_python(0.001)


def test_the_numbers_are_those_of_the_motion_and_of_restitution():
    """By an integrator that shares nothing with the listings; restitution by the event-driven solver."""
    parts, its = branches(CURVE), of_restitution(E, ORDER)

    def rates(tau, state, load):
        x, v = state.tolist()
        z = abs(x)
        branch = next(part for part in parts if z <= part.high)
        return v, load(tau) - np.sign(x) * branch.force(z) - its.coefficient(branch, z, np.sign(x) * v) * v

    for load, x0, expected in ((lambda _: 0.0, 0.5, DECAY), (pulse, 0.0, PULSE)):
        accuracy = {"rtol": 1e-10, "atol": 1e-12, "max_step": 0.01, "args": (load,)}
        run = solve_ivp(rates, (0, 8), [x0, 0.0], "DOP853", t_eval=TIMES, **accuracy)
        np.testing.assert_allclose(run.y[0], expected, atol=1e-6)
    step = 1e-4
    load = np.array([pulse(n * step) for n in range(7001)])
    impacts = event_driven.history(CURVE, rd.Damping.cr(E), TIMES, load=load, load_step=step)
    np.testing.assert_allclose(impacts.displacement, IMPACTS, atol=1e-6)
    stated = re.search(r"those under restitution, ([\d.]+), ([\d.]+), ([\d.]+),", PAGE)
    np.testing.assert_allclose([float(x) for x in stated.groups()], cr_peaks(CURVE, E, 0.5, 3), atol=1e-6)


def test_the_python_listing_gives_the_numbers_and_is_of_second_order(python):
    assert away(python) < 1e-5
    fine, steps = of_python(0.00025), np.array([0.02, 0.01, 0.005, 0.0025, 0.00125])
    errors = [np.sqrt(np.mean((of_python(h) - fine) ** 2)) for h in steps]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(2, abs=0.4)  # erratic


@pytest.mark.parametrize("language", [of_c, of_fortran])
def test_the_compiled_listings_are_the_python_one(language, python, tmp_path):
    np.testing.assert_allclose(language(0.001, tmp_path), python, atol=1e-6)


def test_the_numbers_show_the_mistakes_that_the_page_names():
    source = listing("python")
    mistakes = {
        ("v + h * a\n", "v\n"): 0.0008,  # the velocity of the beginning
        (" + (B1 + f) * max(z - A2, 0.0)", ""): 0.0001,  # V beyond the plateau
        (" * 3.680970", ""): 0.4,  # N_m
        ("A = 2 *", "A ="): 0.3,
        ("(1 - q *", "(1 + q *"): 0.0024,  # the sign of s
    }
    for (right, wrong), stated in mistakes.items():
        assert source.count(right) == 1 and f"is {stated:g} off" in PAGE
        assert away(of_python(0.001, source.replace(right, wrong))) == pytest.approx(stated, rel=0.2)
    first = [away(of_python(h, source.replace("v + h * a\n", "v\n"))) for h in (0.002, 0.001)]
    assert first[0] / first[1] == pytest.approx(2, rel=0.1)


def test_the_constants_are_those_of_the_orders():
    orders, n = (np.array(row[1:], dtype=float) for row in table("order m"))
    np.testing.assert_allclose(n, normalisation(orders), rtol=5e-7)
    assert f"XI = {-np.log(E) / np.pi:.7f}" in listing("c") and f"xi = {-np.log(E) / np.pi:.7f}" in listing("fortran")


def test_the_slopes_for_implicit_schemes():
    x, v, m, a = sp.symbols("x v m a", positive=True)
    force, frequency = sp.Function("f")(x), sp.Function("w")(x)
    potential = sp.Function("V", positive=True)(x)
    total = v**2 + 2 * potential
    share, q = v**2 / total, a * (v**2 / total) ** m
    qs = q * v * sp.sqrt(2 * potential) / total
    damping = frequency * q / (1 - qs)
    by_v = damping * (1 + (2 * m * (1 - share) + qs * (1 - 2 * share)) / (1 - qs))
    along = (qs * (2 * share - 1) * force / (2 * potential) - 2 * m * force / total) / (1 - qs)
    by_x = damping * v * (sp.diff(frequency, x) / frequency + along)
    values = {m: 3, a: sp.Rational(1, 5), v: sp.Rational(7, 10)}
    spring = {potential: x**2 / 3 + x**3 / 5, frequency: 1 + x**2}  # any functions do: f is the slope of V
    spring[force] = sp.diff(spring[potential], x)
    for found, expected in ((sp.diff(damping * v, v), by_v), (sp.diff(damping * v, x), by_x)):
        away = (found - expected).subs(values).subs(spring).doit().subs(x, sp.Rational(3, 10))
        assert abs(float(away)) < 1e-12


def test_the_table_of_what_a_damping_ratio_stands_for():
    head, *rows = table("xi [%]")
    orders = [int(found[1]) for cell in head[1:] if (found := re.search(r"order (\d+)", cell))]
    ratios = np.array([float(row[0]) for row in rows]) / 100
    assert ratios.tolist() == [0.02, 0.03, 0.05, 0.10] and orders == [0, ORDER]
    for xi, row in zip(ratios, rows, strict=True):
        e = np.exp(-log_decrement(xi, np.array(orders)))
        assert row[1:3] == [f"{value:.4f}" for value in e]
    every_e = np.linspace(0.5, 0.98, 17)
    matched = rd.equivalent(every_e, CURVE.yield_displacement_ratio, CURVE.strength_ratio)
    for column, model in enumerate(("CDC", "CDR", "SDR"), start=3):
        assert head[column] == f"e, {model}"
        xi = np.array([one["damping_ratio"] for one in matched if one["damping_model"] == model])
        e = CubicSpline(xi[::-1], every_e[::-1])(ratios)
        np.testing.assert_allclose([float(row[column]) for row in rows], e, atol=0.002)  # CDC's are rough in e


def test_the_table_of_measured_restitutions():
    _, *rows = table("e")
    for e, xi, *_ in rows:
        assert xi == f"{100 * float(damping_ratio(-np.log(float(e)), ORDER)):.1f}"
    stated = {float(row[0]): row[2] for row in rows}
    for slenderness, e in ((10, 0.831), (20, 0.882), (30, 0.892)):
        wall = rd.Wall(thickness=3 / slenderness, height=3.0, hinge_ratio=0.5)
        assert 0.9 * float(wall.restitution_rigid) == pytest.approx(e, abs=5e-4) and str(slenderness) in stated[e]
    for ratio, factor, e in ((5, 0.95, 0.895), (5, 0.67, 0.631), (3, 0.97, 0.825)):  # Housner: 1 - 3/2 sin^2 alpha
        assert factor * (1 - 1.5 / (1 + ratio**2)) == pytest.approx(e, abs=6e-4) and f"{factor}" in stated[e]

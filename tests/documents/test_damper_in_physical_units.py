"""docs/howto/order-m-damper-elsewhere.md in metres and newtons: the second wall's numbers, the conversion, the C++."""

import re
import shutil
import subprocess

import numpy as np
import pytest
from order_m_motion import Branch, of_restitution
from repository import ROOT
from scipy.integrate import solve_ivp

import rockdamp as rd

PAGE = (ROOT / "docs/howto/order-m-damper-elsewhere.md").read_text(encoding="utf-8")
U1, U2, U3, F1, MASS, E, ORDER = 0.02, 0.07, 0.24, 5000.0, 900.0, 0.75, 8
RELEASE, LOAD, DURATION = 0.12, 6000.0, 0.25
STATED = "u1 = 0.02 m, u2 = 0.07 m, u3 = 0.24 m, F1 = 5000 N, m_eff = 900 kg, e = 0.75 and order 8"
LINES = PAGE[PAGE.index("| t [s] | decay, u [m] |") :].split("\n\n")[0].splitlines()[2:]
TIMES, *EXPECTED = np.array([[float(cell) for cell in line.strip("|").split("|")] for line in LINES]).T
DT = 0.0005
NORMALISATION = 2.695845  # of order 8, as the page has it
AMPLITUDE = -2 * float(np.log(E)) / np.pi * NORMALISATION


def listing(language):
    (block,) = re.findall(rf"^```{language}\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)
    return block


def pulse(t):
    return LOAD * np.sin(np.pi * t / DURATION) if t < DURATION else 0.0


def test_the_second_wall_s_numbers_are_those_of_the_motion():
    assert STATED in PAGE and f"(N_m = {NORMALISATION})" in PAGE
    softening = F1 / (U3 - U2)
    shape = (
        (0, U1, F1 / U1, 0, 0),
        (U1, U2, 0, F1, F1 * U1 / 2),
        (U2, U3, -softening, softening * U3, F1 * (U2 - 0.01)),
    )
    parts = [Branch(low, high, *(value / MASS for value in rest)) for low, high, *rest in shape]
    its = of_restitution(E, ORDER)

    def rates(t, state, load):
        x, v = state.tolist()
        z = abs(x)
        branch = next(part for part in parts if z <= part.high)
        return v, load(t) / MASS - np.sign(x) * branch.force(z) - its.coefficient(branch, z, np.sign(x) * v) * v

    for load, start, expected in ((lambda _: 0.0, RELEASE, EXPECTED[0]), (pulse, 0.0, EXPECTED[1])):
        accuracy = {"rtol": 1e-10, "atol": 1e-12, "max_step": 0.004, "args": (load,)}
        run = solve_ivp(rates, (0, TIMES[-1]), [start, 0.0], "DOP853", t_eval=TIMES, **accuracy)
        np.testing.assert_allclose(run.y[0], expected, atol=1e-6)


def test_under_a_ground_acceleration_the_listing_has_the_peak_of_respond():
    wall, curve = rd.Wall(thickness=0.3, height=3.0), rd.TrilinearCurve(0.06, 0.72)
    u3, mass, factor = map(float, (wall.instability_displacement, wall.effective_mass, wall.excitation_factor))
    f1, names = 0.72 * float(wall.rigid_strength), {}
    assert float(wall.rocking_onset(0.72)) == pytest.approx(f1 / (factor * mass))
    elapsed = DT * np.arange(4001)
    ground = 4 * np.sin(4 * np.pi * elapsed) * (elapsed < 0.5)
    exec(listing("python"), names)  # at e = 0.85 and order 16
    names |= {"A1": 0.06, "A2": 0.28, "B1": 1.0}
    p, x, v, a, peak = np.sqrt(f1 / (mass * u3)), 0.0, 0.0, 0.0, 0.0
    for a_g in ground[1:]:
        x, v, a = names["step"](x, v, a, -factor * mass * a_g / f1, p * DT)
        peak = max(peak, abs(x))
    found = rd.respond(wall, curve, rd.Damping.of_restitution(0.85, "ECD16"), rd.Record(elapsed, ground))
    assert 0.1 < peak == pytest.approx(float(found["peak"]), rel=1e-3)


def test_the_python_listing_converted_as_the_page_says_gives_them():
    names = {}
    exec(listing("python"), names)
    names |= {"A1": U1 / U3, "A2": U2 / U3, "A3": 1.0, "B1": 1.0, "A": AMPLITUDE, "M": ORDER}
    p = np.sqrt(F1 / (MASS * U3))
    for forced, expected in enumerate(EXPECTED):
        x = 0.0 if forced else RELEASE / U3
        v, a, found = 0.0, -names["curve"](x)[0] if x else 0.0, []
        for n in range(1, round(TIMES[-1] / DT) + 1):
            x, v, a = names["step"](x, v, a, pulse(n * DT) / F1 if forced else 0.0, p * DT)
            if np.isclose(n * DT, TIMES).any():
                found.append(U3 * x)
        np.testing.assert_allclose(found, expected, atol=1e-5)


CPP_MAIN = """
#include <cstdio>
// Newmark (1/2, 1/4) with Newton's iterations, as a zero-length element uses a material; the curve stands beside it.
int main() {
    const double f1 = %(F1)r, u1 = %(U1)r, u2 = %(U2)r, u3 = %(U3)r, mass = %(MASS)r, dt = %(DT)r, pi = std::acos(-1.0);
    for (int forced = 0; forced < 2; forced++) {
        OrderMDamper original(1, u1, u2, u3, f1, mass, %(AMPLITUDE)r, %(ORDER)d);
        UniaxialMaterial *damper = original.getCopy();
        double u = forced ? 0.0 : %(RELEASE)r, v = 0.0, a = 0.0;
        auto spring = [&](double x, double *k) {
            double z = std::fabs(x), f = f1;
            *k = 0.0;
            if (z < u1) { f = f1 / u1 * z; *k = f1 / u1; }
            if (z > u2) { f = f1 * (u3 - z) / (u3 - u2); *k = -f1 / (u3 - u2); }
            return std::copysign(f, x);
        };
        double k;
        a = u == 0.0 ? 0.0 : -spring(u, &k) / mass;
        for (long n = 1; n <= std::lround(%(END)r / dt); n++) {
            double t = n * dt, load = forced && t < %(DURATION)r ? %(LOAD)r * std::sin(pi * t / %(DURATION)r) : 0.0;
            double next = u + dt * v + dt * dt / 2 * a, v_next = 0.0, a_next = 0.0;
            for (int i = 0; i < 50; i++) {
                a_next = 4 / (dt * dt) * (next - u - dt * v) - a;
                v_next = v + dt / 2 * (a + a_next);
                damper->setTrialStrain(next, v_next);
                double residual = load - mass * a_next - damper->getStress() - spring(next, &k);
                if (std::fabs(residual) < 1e-8 * f1) break;
                k += damper->getTangent() + 2 / dt * damper->getDampTangent();
                next += residual / (4 / (dt * dt) * mass + k);
                if (i == 49) return 1;
            }
            damper->commitState();
            u = next; v = v_next; a = a_next;
            if (n %% std::lround(0.25 / dt) == 0) std::printf("%%.9f\\n", u);
        }
        delete damper;
    }
}
"""


def test_the_c_plus_plus_material_compiles_and_gives_them(tmp_path):
    """Against a stand-in of OpenSees' interface; the iterations converge although the tangent in u is left out."""
    compiler = shutil.which("c++")
    if not compiler:
        pytest.skip("there is no c++")
    assert "it was not linked into OpenSees" in PAGE.replace("\n", " ")
    source, program = tmp_path / "damper.cpp", tmp_path / "damper"
    numbers = {name: globals()[name] for name in re.findall(r"%\((\w+)\)", CPP_MAIN) if name != "END"}
    source.write_text(listing("cpp") + CPP_MAIN % {**numbers, "AMPLITUDE": float(AMPLITUDE), "END": float(TIMES[-1])})
    include = f"-I{ROOT / 'tests/support/opensees_stand_in'}"
    command = [compiler, "-std=c++17", "-O1", "-Wall", "-Werror", include, str(source), "-o", str(program)]
    subprocess.run(command, check=True)
    printed = subprocess.run([str(program)], check=True, capture_output=True, text=True).stdout
    u = np.reshape(np.array(printed.split(), dtype=float), (2, -1))
    rows = np.rint(TIMES / 0.25).astype(int) - 1
    np.testing.assert_allclose(u[:, rows], EXPECTED, atol=1e-5)


def test_the_host_s_call_of_the_page_is_the_example_s():
    """Every name and keyword of the listing for OpenSees stands in the example."""
    example = (ROOT / "examples/opensees/order_m.py").read_text(encoding="utf-8")
    (call,) = re.findall(r"make_joint\((.*)\)\n", listing("py"))
    (signature,) = re.findall(r"^def make_joint\((.*)\):", example, flags=re.MULTILINE)
    for keyword in re.findall(r"(\w+)=", call):
        assert keyword in re.split(r"[,=] ?", signature)
    assert "def analyze(joints, steps, dt):" in example

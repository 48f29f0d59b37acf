"""The restitution of two rigid bodies on contacts, by Moreau's time stepping and Siconos.

Contacts of Newton's law at the corners and supports that hold: the impact takes as much as
`restitution_impulsive` says, and not Eq. (7).
"""

import json
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from contacts import GRAVITY, TwoBodiesOnContacts
from repository import ROOT
from scipy.integrate import solve_ivp

from rockdamp.histories.loads import support_factors
from rockdamp.mechanics.wall import Wall

# Thickness, height [m] and h1/h.
SHAPES = (
    (0.3, 3.0, 0.5),
    (0.3, 4.5, 0.7),
    (0.4, 4.0, 0.6),
    (0.3, 2.1, 0.62),
    (0.25, 5.0, 0.7),
)
LIGHT = [Wall(t, h, hinge_ratio=r) for t, h, r in SHAPES]
LOADED = [replace(wall, overburden_ratio=2.0) for wall in LIGHT]
HEAVY = [
    Wall(t, h, hinge_ratio=r, overburden_ratio=1.0, overburden_mass=part)
    for t, h, r in SHAPES
    for part in (0.6, 1.0)
]
STEP = 5e-4  # in tau


def name_wall(wall):
    return f"{wall.thickness} {wall.height} {wall.overburden_ratio} {wall.overburden_mass}"


def remaining(wall, peaks):
    """Return sqrt(V) of each peak over that of the one before, with V of the rigid law."""
    energy = float(wall.rigid_strength) * peaks - float(wall.rigid_stiffness) * peaks**2 / 2
    return np.sqrt(energy[1:] / energy[:-1])


def release(wall, restitution=0.0):
    """Return the share of sqrt(V) after the first impact, and the largest opening over u_ins."""
    u_ins = float(wall.instability_displacement)
    step = STEP / float(wall.frequency_parameter)
    peaks, opening = TwoBodiesOnContacts(wall).peaks(0.5 * u_ins, step, 1, restitution)
    return remaining(wall, peaks)[0], opening / u_ins


every_wall = pytest.mark.parametrize("wall", LIGHT + LOADED, ids=name_wall)


@every_wall
def test_impact_has_the_impulses_of_all_contacts(wall):
    """Both bodies go on rocking at once, on their new corners: nothing bounces."""
    bodies = TwoBodiesOnContacts(wall)
    after = bodies.after_impact()
    e = -float(bodies.hinge @ after)
    assert e == pytest.approx(float(wall.restitution_impulsive), rel=1e-12)
    np.testing.assert_allclose(after, -e * bodies.rocking(-1), atol=1e-12)


@every_wall
def test_released_wall_has_the_impulsive_restitution(wall):
    e, opening = release(wall)
    assert e == pytest.approx(float(wall.restitution_impulsive), abs=1e-3)
    assert opening < 1e-12
    assert float(wall.restitution_rigid) - e > 0.03  # Eq. (7) is another


@pytest.mark.parametrize("wall", [LIGHT[1], LOADED[2]], ids=["slender", "loaded"])
@pytest.mark.parametrize(("bounce", "least_opening"), [(0.3, 1e-3), (0.6, 5e-3)])
def test_bouncing_corners_lose_hardly_less(wall, bounce, least_opening):
    """The energy of the bounces is lost at the next contacts."""
    e, opening = release(wall, bounce)
    assert opening > least_opening
    assert e == pytest.approx(float(wall.restitution_impulsive), abs=2e-3)


@pytest.mark.parametrize("wall", LIGHT, ids=name_wall)
def test_rocking_has_own_inertia_and_half_the_strength(wall):
    """The coordinate u carries half of the mass and of the force."""
    bodies = TwoBodiesOnContacts(wall)
    mode = bodies.rocking(1)
    thick = replace(wall, own_inertia=True)
    assert -bodies.force @ mode == pytest.approx(float(wall.rigid_strength) / 2, rel=1e-12)
    inertia = 2 * mode @ bodies.mass @ mode
    assert inertia == pytest.approx(float(thick.effective_mass), rel=1e-12)


@pytest.mark.parametrize("wall", HEAVY, ids=name_wall)
def test_mass_on_top_makes_the_wall_slower(wall):
    """The quarter periods differ as 1/p, both with bodies that are not slender."""
    light = replace(wall, overburden_mass=0.0)
    u = 0.5 * float(wall.instability_displacement)
    step = STEP / float(wall.frequency_parameter)
    durations = []
    for loaded in (wall, light):
        bodies = TwoBodiesOnContacts(loaded)
        bodies.peaks(u, step, 1)
        durations.append(bodies.fall)
    slower = float(light.frequency_parameter / wall.frequency_parameter)
    assert slower > 1.02
    assert durations[0] / durations[1] == pytest.approx(slower, rel=1e-3)


# --- supports that move apart --------------------------------------------------------------------


@pytest.mark.parametrize("r", [0.5, 0.6, 0.7])
def test_load_of_two_supports_by_virtual_work(r):
    """The motion of the line of supports, and the weights across it, on the rocking."""
    h = 3.0
    wall = Wall(0.05, h, hinge_ratio=r)  # slender: the thickness does not enter the load
    bodies = TwoBodiesOnContacts(wall)
    mode = bodies.rocking(1)
    centres = np.array([r * h / 2, (1 + r) * h / 2])

    def line(base, top):
        tilt = (top - base) / h
        x1, x2 = base + tilt * centres
        return np.array([x1, 0, -tilt, x2, 0, -tilt])

    masses = np.diag(bodies.mass)[[0, 3]]
    # Where the top is ahead, the weights pull along the line.
    loads = [
        -mode @ bodies.mass @ line(1, 0),
        -mode @ bodies.mass @ line(0, 1),
        -(masses @ mode[[0, 3]]) / h,
    ]
    factors = -2 * np.array(loads) / float(wall.mass)
    np.testing.assert_allclose(factors, support_factors(wall), rtol=1e-3)


BASE_FREQUENCY, TOP_FREQUENCY = 9.0, 12.0  # [rad s-1]
END = 1.2  # in tau


def shaken_supports(wall):
    """Return the acceleration of a base, and the motion of the top relative to it, from rest."""
    amplitude = 0.3 * float(wall.rocking_onset())
    size = 0.1 * float(wall.instability_displacement)
    w = TOP_FREQUENCY

    def base(t):
        return amplitude * np.sin(BASE_FREQUENCY * t)

    def relative(t):
        return size * np.array([1 - np.cos(w * t), w * np.sin(w * t), w * w * np.cos(w * t)])

    return base, relative


def reference_motion(wall, weights, start, ends):
    """Return u of one oscillator under the weighted motions of both supports, by DOP853."""
    base, relative = shaken_supports(wall)
    mode = TwoBodiesOnContacts(wall).rocking(1)
    inertia = 2 * mode @ TwoBodiesOnContacts(wall).mass @ mode
    strength, stiffness = float(wall.rigid_strength), float(wall.rigid_stiffness)

    def rates(t, state):
        drift, _, swing = relative(t)
        motions = np.array([base(t), base(t) + swing, -GRAVITY * drift])
        pull = strength - stiffness * state[0]
        return state[1], -(float(wall.mass) * (weights @ motions) + pull) / inertia

    span = (0, ends[-1])
    return solve_ivp(rates, span, (start, 0.0), "DOP853", t_eval=ends, rtol=1e-9, atol=1e-12).y[0]


@pytest.mark.parametrize(("r", "psi"), [(0.5, 0.0), (0.6, 1.0), (0.7, 0.0)])
def test_bodies_between_moving_supports(r, psi):
    """A released wall that has not come back to u = 0, whose base shakes under a swinging top."""
    wall = Wall(0.05, 3.0, hinge_ratio=r, overburden_ratio=psi)
    u_ins = float(wall.instability_displacement)
    start, step = 0.6 * u_ins, 2e-4
    ends = step * np.arange(1, round(END / float(wall.frequency_parameter) / step))
    base, relative = shaken_supports(wall)
    middles = ends - step / 2
    motion = np.stack([relative(middles), relative(ends)], axis=1)
    bodies = TwoBodiesOnContacts(wall).shaken(start, step, base(middles), motion)
    expected = reference_motion(wall, support_factors(wall), start, ends)
    is_free = expected > 0.25 * u_ins  # beyond it no joint of this side has closed
    assert is_free[:200].all()
    last = len(is_free) if is_free.all() else int(is_free.argmin())
    np.testing.assert_allclose(bodies[:last], expected[:last], atol=1e-3 * start)
    # The mean of both supports, without the tilt of their line, is another motion.
    mean = reference_motion(wall, np.array([0.5, 0.5, 0.0]), start, ends)
    assert np.abs(mean[:last] - expected[:last]).max() > 3e-3 * start


# --- Siconos -------------------------------------------------------------------------------------

PYTHON = "/usr/bin/python3"


@pytest.mark.peers
@pytest.mark.parametrize("wall", [*LIGHT[1:3], *LOADED[1:3]], ids=name_wall)
def test_siconos_has_the_same_restitution(wall):
    """Its MLCP takes the supports as equations. Debian's Python has it, the project's need not.

    The contacts are redundant at the impact, and at a single step its solver may take other
    impulses: the median of three steps counts.
    """
    try:
        subprocess.run([PYTHON, "-c", "import siconos.kernel"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("Siconos is not installed (Debian: python3-siconos)")
    bodies = TwoBodiesOnContacts(wall)
    u = 0.5 * float(wall.instability_displacement)
    names = ("mass", "force", "push", "gaps", "held", "hinge")
    problem = {name: getattr(bodies, name).tolist() for name in names}
    problem["q"] = (u * bodies.rocking(1)).tolist()
    problem["restitution"] = 0.0
    shares = []
    for factor in (0.8, 1.0, 1.2):
        problem["step"] = factor * STEP / float(wall.frequency_parameter)
        process = subprocess.run(
            [PYTHON, ROOT / "tests/support/siconos_wall.py"],
            input=json.dumps(problem),
            capture_output=True,
            text=True,
        )
        assert process.returncode == 0, process.stderr
        peak = float(process.stdout.splitlines()[-1])
        shares.append(remaining(wall, np.array([u, peak]))[0])
    assert np.median(shares) == pytest.approx(float(wall.restitution_impulsive), abs=1e-3)

"""Which restitution do two rigid bodies on contacts have? By Moreau's time stepping and Siconos.

Contacts of Newton's law at the corners and supports that hold: the impact takes what `restitution_impulsive` says,
not Eq. (7).
"""

import json
import subprocess
from dataclasses import replace

import numpy as np
import pytest
from contacts import TwoBodiesOnContacts
from repository import ROOT
from scipy.integrate import solve_ivp

from rockdamp.histories.loads import support_factors
from rockdamp.mechanics.wall import Wall

SHAPES = (
    (0.3, 3.0, 0.5),
    (0.3, 4.5, 0.7),
    (0.4, 4.0, 0.6),
    (0.3, 2.1, 0.62),
    (0.25, 5.0, 0.7),
)  # t, h [m], h1/h
WALLS = [
    Wall(t, h, hinge_ratio=r, overburden_ratio=psi) for t, h, r in SHAPES for psi in (0.0, 2.0)
]
HEAVY = [
    replace(wall, overburden_ratio=1.0, overburden_mass=part)
    for wall in WALLS[::2]
    for part in (0.6, 1.0)
]
STEP = 5e-4  # of tau


def lost(wall, peaks):
    """Return sqrt(V) of each peak over the one before, V of the rigid law."""
    energy = float(wall.rigid_strength) * peaks - float(wall.rigid_stiffness) * peaks**2 / 2
    return np.sqrt(energy[1:] / energy[:-1])


def released(wall, restitution=0.0):
    u, p = 0.5 * float(wall.instability_displacement), float(wall.frequency_parameter)
    peaks, apart = TwoBodiesOnContacts(wall).peaks(u, STEP / p, 1, restitution)
    return lost(wall, peaks)[0], apart / float(wall.instability_displacement)


@pytest.mark.parametrize(
    "wall", WALLS, ids=lambda wall: f"{wall.thickness} {wall.height} {wall.overburden_ratio}"
)
def test_the_impact_on_contacts_is_that_of_every_impulse(wall):
    bodies = TwoBodiesOnContacts(wall)
    after = bodies.after_impact()
    e = -float(bodies.hinge @ after)
    assert e == pytest.approx(float(wall.restitution_impulsive), rel=1e-12)
    # The impulses press, and both bodies go on rocking at once, on their new corners: nothing bounces.
    np.testing.assert_allclose(after, -e * bodies.rocking(-1), atol=1e-12)
    e, apart = released(wall)
    assert e == pytest.approx(float(wall.restitution_impulsive), abs=1e-3) and apart < 1e-12
    assert float(wall.restitution_rigid) - e > 0.03  # Eq. (7) is another


@pytest.mark.parametrize("wall", [WALLS[2], WALLS[5]], ids=["slender", "loaded"])
def test_corners_that_bounce_lose_hardly_less(wall):
    """They lift off together again and again; what they keep goes into bounces, which the next contacts take."""
    for bounce, apart_at_least in ((0.3, 1e-3), (0.6, 5e-3)):
        e, apart = released(wall, bounce)
        assert apart > apart_at_least
        assert e == pytest.approx(float(wall.restitution_impulsive), abs=2e-3)


@pytest.mark.parametrize("wall", WALLS[::2], ids=lambda wall: f"{wall.thickness} {wall.height}")
def test_the_mechanism_without_impact_is_the_paper_s(wall):
    """Its inertia in the slender limit, and half of F0: u carries half of the mass and of the force."""
    bodies = TwoBodiesOnContacts(wall)
    mode = bodies.rocking(1)
    assert -bodies.force @ mode == pytest.approx(float(wall.rigid_strength) / 2, rel=1e-12)
    r, slenderness = float(wall.hinge_ratio), float(wall.slenderness)
    correction = (3 - 2 * r) / (r**2 * (1 - r)) / slenderness**2
    assert 2 * mode @ bodies.mass @ mode == pytest.approx(
        float(wall.effective_mass) * (1 + correction), rel=1e-12
    )


@pytest.mark.parametrize("r", [0.5, 0.6, 0.7])
def test_supports_that_move_apart_load_the_bodies_on_contacts_as_virtual_work_says(r):
    """The motion of the line of supports, and the weights across it, on the rocking that the contacts leave."""
    wall = Wall(0.05, 3.0, hinge_ratio=r)  # slender: the bodies' thickness is not in the load
    bodies, h = TwoBodiesOnContacts(wall), 3.0
    mode, centres = bodies.rocking(1), np.array([r * h / 2, (1 + r) * h / 2])

    def line(base, top):
        turned = (top - base) / h
        (x1, x2) = base + turned * centres
        return np.array([x1, 0, -turned, x2, 0, -turned])

    masses = np.diag(bodies.mass)[[0, 3]]
    # u carries half of the mass and of the force; where the top is ahead, the weights pull along the line.
    loads = [
        -mode @ bodies.mass @ line(1, 0),
        -mode @ bodies.mass @ line(0, 1),
        -(masses @ mode[[0, 3]]) / h,
    ]
    found = -2 * np.array(loads) / float(wall.mass)
    np.testing.assert_allclose(found, support_factors(wall), rtol=1e-3)


@pytest.mark.parametrize(("r", "psi"), [(0.5, 0.0), (0.6, 1.0), (0.7, 0.0)])
def test_bodies_on_contacts_move_as_the_load_of_two_moving_supports_says(r, psi):
    """A released wall that has not come back to u = 0, whose base shakes under a swinging top, against DOP853."""
    wall = Wall(0.05, 3.0, hinge_ratio=r, overburden_ratio=psi)
    bodies, p = TwoBodiesOnContacts(wall), float(wall.frequency_parameter)
    u_ins, onset, w, h = (
        float(wall.instability_displacement),
        float(wall.rocking_onset()),
        12.0,
        2e-4,
    )

    def base(t):
        return 0.3 * onset * np.sin(9.0 * t)

    def apart(t):  # begins at rest
        size = 0.1 * u_ins
        return size * np.array([1 - np.cos(w * t), w * np.sin(w * t), w * w * np.cos(w * t)])

    mode = bodies.rocking(1)
    inertia, per_mass = 2 * mode @ bodies.mass @ mode, float(wall.mass)

    ends, start = h * np.arange(1, round(1.2 / p / h)), 0.6 * u_ins

    def motion_under(weights):
        def rates(t, state):
            drift, _, swing = apart(t)
            equal = weights @ np.array([base(t), base(t) + swing, -9.80665 * drift])
            pull = float(wall.rigid_strength) - float(wall.rigid_stiffness) * state[0]
            return state[1], -(per_mass * equal + pull) / inertia

        return solve_ivp(
            rates, (0, ends[-1]), (start, 0.0), "DOP853", t_eval=ends, rtol=1e-9, atol=1e-12
        ).y[0]

    expected = motion_under(support_factors(wall))
    found = bodies.followed(
        start, h, base(ends - h / 2), np.stack([apart(ends - h / 2), apart(ends)], axis=1)
    )
    free = expected > 0.25 * u_ins  # beyond it no joint of this side has closed
    assert free[:200].all()
    last = len(free) if free.all() else int(free.argmin())
    np.testing.assert_allclose(found[:last], expected[:last], atol=1e-3 * start)
    other = motion_under(
        [0.5, 0.5, 0.0]
    )  # the mean of both supports, without the tilt of their line
    assert np.abs(other[:last] - expected[:last]).max() > 3e-3 * start


@pytest.mark.parametrize(
    "wall", HEAVY, ids=lambda wall: f"{wall.thickness} {wall.height} {wall.overburden_mass}"
)
def test_a_mass_on_the_wall_has_the_inertia_of_the_closed_form(wall):
    """A third body lies on the head and makes the wall slower."""
    light = replace(wall, overburden_mass=0.0)
    bodies, same = TwoBodiesOnContacts(wall), TwoBodiesOnContacts(light)
    falls = []
    for each in (bodies, same):
        each.peaks(
            0.5 * float(wall.instability_displacement), STEP / float(wall.frequency_parameter), 1
        )
        falls.append(each.fall)
    # A quarter of the first period, which goes with 1/p; both in the same numbers of bodies that are not slender.
    slower = float(light.frequency_parameter / wall.frequency_parameter)
    assert slower > 1.02 and falls[0] / falls[1] == pytest.approx(slower, rel=1e-3)
    assert slower**2 == pytest.approx(float(wall.inertia_ratio), rel=1e-12)


@pytest.mark.peers
@pytest.mark.parametrize(
    "wall", WALLS[2:6], ids=lambda wall: f"{wall.thickness} {wall.height} {wall.overburden_ratio}"
)
def test_siconos_says_the_same(wall):
    """Its MLCP takes the supports as equations; Debian's Python has it, ours need not.

    The contacts are redundant at the impact, and at a single step its solver may take other impulses: the median of
    three steps counts.
    """
    python = "/usr/bin/python3"
    try:
        subprocess.run([python, "-c", "import siconos.kernel"], check=True, capture_output=True)
    except (OSError, subprocess.CalledProcessError):
        pytest.skip("Siconos is not installed (Debian: python3-siconos)")
    bodies, u = TwoBodiesOnContacts(wall), 0.5 * float(wall.instability_displacement)
    names = ("mass", "force", "push", "gaps", "held", "hinge")
    given = {name: getattr(bodies, name).tolist() for name in names}
    given |= {"q": (u * bodies.rocking(1)).tolist(), "restitution": 0.0}
    kept = []
    for step in (0.8 * STEP, STEP, 1.2 * STEP):
        stated = json.dumps(given | {"step": step / float(wall.frequency_parameter)})
        command = [python, ROOT / "tests/support/siconos_wall.py"]
        run = subprocess.run(command, input=stated, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
        kept += lost(wall, np.array([u, float(run.stdout.splitlines()[-1])])).tolist()
    assert np.median(kept) == pytest.approx(float(wall.restitution_impulsive), abs=1e-3)

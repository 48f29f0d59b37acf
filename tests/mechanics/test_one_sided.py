"""Walls that rock to one side: their forces by statics, ties, and the dashpot of a stop by its own motion."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import rockdamp as rd
from rockdamp.mechanics.one_sided import OneSidedForce, Stop, parting_loss, stop_damping_ratio

CURVE = rd.TrilinearCurve(yield_displacement_ratio=0.04, strength_ratio=0.85)
BLOCK = rd.Parapet(thickness=0.8, height=12.0)
STRIP = rd.Wall(thickness=0.3, height=4.5, hinge_ratio=0.6, overburden_ratio=1.0)


def test_a_tie_at_the_top_adds_its_moment_about_the_base_corner():
    tie = rd.Tie(stiffness=2e6, strength=30e3)
    force = rd.OneSidedWall(BLOCK, tie).force(CURVE)
    # The acceleration that opens the block by statics: m a h/2 = W t/2 + T h, and by F: m a = F0 (1 + tie strength).
    statics = (float(BLOCK.weight) * 0.8 / 2 + 30e3 * 12.0) / (float(BLOCK.mass) * 12.0 / 2)
    assert float(BLOCK.rigid_strength) * (1 + force.tie_strength) / float(BLOCK.mass) == pytest.approx(statics)


def test_a_tie_at_the_hinge_of_a_strip_adds_its_work():
    tie = rd.Tie(stiffness=2e6, strength=5e3)
    force = rd.OneSidedWall(STRIP, tie).force(CURVE)
    # Virtual work of a displacement u at the hinge: the load m a does m a u/2, the tie T u.
    assert float(STRIP.rigid_strength) * force.tie_strength / 2 == pytest.approx(5e3)


def test_a_lower_tie_is_softer_weaker_and_later():
    low = rd.OneSidedWall(BLOCK, rd.Tie(2e6, 30e3, gap=0.01, rupture=0.2, height_ratio=0.5)).force(CURVE)
    top = rd.OneSidedWall(BLOCK, rd.Tie(2e6, 30e3, gap=0.01, rupture=0.2)).force(CURVE)
    assert low.tie_stiffness == pytest.approx(top.tie_stiffness / 4)
    assert low.tie_strength == pytest.approx(top.tie_strength / 2)
    assert (low.tie_gap, low.tie_rupture) == pytest.approx((2 * top.tie_gap, 2 * top.tie_rupture))
    # Its work to a displacement u is that of its own force over its own stretch.
    yielded = 30e3 * (0.5 * 0.4 - 0.01 - 30e3 / 2e6 / 2)
    u, scale = 0.4 / float(BLOCK.instability_displacement), float(BLOCK.rigid_strength * BLOCK.instability_displacement)
    at_yield = low.tie_strength / low.tie_stiffness
    assert low.tie_strength * (u - low.tie_gap - at_yield / 2) * scale / 2 == pytest.approx(yielded)


def test_a_tie_is_stretched_beyond_its_slack_until_it_breaks():
    tie = rd.Tie(2e6, 30e3, gap=0.01, rupture=0.2, height_ratio=0.5)
    assert tie.stretch([-0.1, 0.01, 0.1, 0.3, 0.5]).tolist() == pytest.approx([0.0, 0.0, 0.04, 0.14, 0.2])


def test_the_energy_is_the_integral_of_the_force():
    force = OneSidedForce(CURVE, initial=0.5)
    slope, initial, b1, ks, *_, a3, _, _, _, _ = force.parameters()
    x = np.linspace(0, 1, 100001)
    f = np.minimum(np.minimum(initial + slope * x, b1), ks * (a3 - x))
    assert force.energy(0.9) == pytest.approx(np.trapezoid(f[x <= 0.9], x[x <= 0.9]), rel=1e-6)


def test_restitution_of_a_facade_is_sorrentinos():
    # 0.478 at h/t = 8 by hand: sin^2 = 1/65.
    facade = rd.OneSidedWall(rd.Parapet(thickness=0.5, height=4.0))
    assert facade.restitution_rigid == pytest.approx(1.05 * (1 - 1.5 / 65) ** 2 * (1.5 * 64 / 65 - 1))
    assert facade.restitution_rigid == pytest.approx(0.478, abs=5e-4)


@pytest.mark.parametrize("e", [0.05, 0.135335, 0.3, 0.5, 0.7, 0.95])
@pytest.mark.parametrize("pulls", [True, False])
def test_an_impact_on_the_stop_takes_restitution(e, pulls):
    xi = stop_damping_ratio(e, pulls)

    def rates(_, y):
        stop = y[0] + 2 * xi * y[1]
        return y[1], -(stop if pulls else min(stop, 0.0))

    def leaves(t, y):
        return y[0] if pulls or t < 1e-9 else y[0] + 2 * xi * y[1]

    leaves.terminal, leaves.direction = True, 1
    ended = solve_ivp(rates, (0, 60), (-1e-12, -1.0), events=leaves, rtol=1e-11, atol=1e-13)
    assert ended.y[1, -1] == pytest.approx(e, abs=1e-7)


def test_the_loss_of_a_stop_that_cannot_pull_is_smooth_where_it_is_critical():
    xi = 1 + np.array([-2e-4, -1e-4, -1e-6, 1e-6, 1e-4, 2e-4])
    assert np.diff([parting_loss(each) for each in xi]) == pytest.approx(4 / 3 * np.diff(xi), rel=1e-3)


def test_both_laws_of_the_stop_are_not_to_be_mixed():
    assert np.exp(-parting_loss(stop_damping_ratio(0.3, pulls=True))) == pytest.approx(0.397, abs=1e-3)


def test_a_stop_has_its_dashpot_and_a_rigid_one_has_none():
    stop = Stop(np.array([100.0, np.inf]), 0.5, pulls=True)
    assert stop.coefficient == pytest.approx([2 * stop_damping_ratio(0.5, True) * 10, 0.0])


@pytest.mark.parametrize(
    ("make", "text"),
    [
        (lambda: rd.Tie(2e6, 0.0), "tie strength is 0.0; it must be greater than 0"),
        (lambda: rd.Tie(0.0, 3e3), "tie stiffness is 0.0"),
        (lambda: rd.Tie(2e6, 3e3, gap=-1e-3), "tie gap is -0.001"),
        (lambda: rd.Tie(2e6, 3e3, rupture=1e-3), "tie rupture is 0.001; it must be at least strength/stiffness"),
        (lambda: rd.Tie(2e6, 3e3, height_ratio=0.0), "tie height_ratio is 0.0"),
        (lambda: rd.OneSidedWall(BLOCK, stop_stiffness=1e3).force(CURVE), "stop_stiffness is 1000.0; it must be at le"),
        (lambda: rd.OneSidedWall(BLOCK, initial_strength_ratio=0.9).force(CURVE), "at most b1 of the curve, 0.85"),
        (lambda: rd.OneSidedWall(rd.TrilinearCurve.preset("new")), "it must be a Wall or a Parapet"),
        (lambda: Stop(1e4, 0.0), "restitution (e) is 0.0; it must be greater than 0"),
        (lambda: Stop(1e4, 1e-4), "restitution (e) is 0.0001; it must be at least 0.001"),
        (lambda: Stop(-1.0, 0.5), "stiffness of the stop is -1.0"),
    ],
)
def test_bad_input_is_one_line(make, text):
    with pytest.raises(rd.InputError, match=".*") as error:
        make()
    assert text in str(error.value)
    assert "\n" not in str(error.value)

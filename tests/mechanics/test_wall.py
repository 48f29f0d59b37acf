"""Walls and parapets: published values, consistency of units, shapes and bad input."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from rockdamp.errors import InputError
from rockdamp.mechanics.wall import HINGE_RANGE, SORRENTINO_RATIO, Parapet, Wall
from rockdamp.vocabulary import STANDARD_GRAVITY

# The wall of Fig. 5: t = 0.3 m, slenderness 15, h1/h = 0.7, no overburden.
FIG_5 = {"thickness": 0.3, "height": 4.5, "hinge_ratio": 0.7}


def test_the_wall_of_fig_5_has_the_frequency_parameter_worked_out_by_hand():
    wall = Wall(**FIG_5)
    # p^2 = (2 W/h1)/(2 m/3) = 3 g/h1.
    assert wall.frequency_parameter == pytest.approx(np.sqrt(3 * 9.80665 / 3.15), rel=1e-14)
    assert wall.frequency_parameter == pytest.approx(3.06, abs=5e-3)
    assert wall.instability_displacement == pytest.approx(0.3, rel=1e-14)
    assert wall.mass == pytest.approx(1800 * 0.3 * 4.5, rel=1e-14)


def test_the_specimen_of_fig_8_has_about_the_overburden_and_the_mass_known_of_the_campaign():
    # 44 kN on 734 to 741 kg (a secondary source): the paper's O/W of 6.2 on 1.438 m of 1835 kg/m3.
    wall = Wall(0.102, 0.102 * 27, width=1.438, density=1835.0, hinge_ratio=0.57, overburden_ratio=6.2)
    assert 730 < wall.mass < 745
    assert wall.overburden == pytest.approx(44e3, rel=0.03)
    assert wall.overburden == pytest.approx(6.2 * wall.mass * STANDARD_GRAVITY, rel=1e-14)
    assert wall.slenderness == pytest.approx(27, rel=1e-14)


def test_sorrentino_s_ratio_takes_the_analytical_restitution_to_the_experimental_one_of_the_paper():
    # Section 4.1: e_exp = 0.90 e_an, and 0.84 to 0.90 measured on specimens of slenderness 27, h1/h = 0.57.
    assert SORRENTINO_RATIO == 0.90
    assert 0.84 <= SORRENTINO_RATIO * Wall(0.102, 0.102 * 27, hinge_ratio=0.57).restitution_rigid <= 0.90


def test_the_width_and_the_density_scale_forces_and_leave_the_dimensionless_problem_alone():
    alike = {"hinge_ratio": 0.6, "overburden_ratio": 1.5}
    one, other = Wall(0.3, 4.5, **alike), Wall(0.3, 4.5, width=2.5, density=900.0, **alike)
    assert other.rigid_strength == pytest.approx(1.25 * one.rigid_strength, rel=1e-14)
    for name in ("frequency_parameter", "instability_displacement", "load_factor", "restitution_rigid"):
        assert getattr(other, name) == pytest.approx(getattr(one, name), rel=1e-14)


def test_the_rigid_law_starts_at_the_strength_is_odd_and_ends_at_the_instability_displacement():
    for wall in (Wall(0.3, 4.5, overburden_ratio=1.0), Parapet(0.3, 1.5, overburden_ratio=1.0)):
        u_ins = wall.instability_displacement
        assert wall.rigid_force(0.0) == 0.0
        assert wall.rigid_force(1e-12 * u_ins) == pytest.approx(wall.rigid_strength, rel=1e-11)
        assert wall.rigid_force(0.25 * u_ins) == pytest.approx(0.75 * wall.rigid_strength, rel=1e-14)
        assert wall.rigid_force(-0.25 * u_ins) == -wall.rigid_force(0.25 * u_ins)
        np.testing.assert_array_equal(wall.rigid_force(np.array([1.01, -2.0]) * u_ins), 0.0)


@pytest.mark.filterwarnings("ignore::rockdamp.errors.InputWarning")  # beyond any wall
def test_the_squatter_the_wall_the_lower_the_restitution_by_either_principle():
    walls = Wall(0.3, 0.3 * np.linspace(6, 40, 30)[:, None], hinge_ratio=np.linspace(0.4, 0.8, 5))
    for value in (walls.restitution_rigid, walls.restitution_impulsive, Parapet(0.3, walls.height).restitution_rigid):
        assert np.all(np.diff(value, axis=0) > 0)
        assert np.all(value < 1)
    assert np.all(walls.restitution_impulsive < walls.restitution_rigid)


BAD = [
    ("thickness", 0.0, "greater than 0"),
    ("height", -4.0, "greater than 0"),
    ("width", 0.0, "greater than 0"),
    ("density", 0.0, "greater than 0"),
    ("overburden_ratio", -0.5, "at least 0"),
    ("eccentricity", 0.1501, "at most half the thickness"),
    ("eccentricity", -0.2, "at most half the thickness"),
]


@pytest.mark.parametrize("kind", [Wall, Parapet])
@pytest.mark.parametrize(("name", "value", "allowed"), BAD)
def test_a_bad_value_is_refused_with_its_name_the_value_and_what_is_allowed(kind, name, value, allowed):
    given = {"thickness": 0.3, "height": 4.5, name: value}
    with pytest.raises(InputError) as caught:
        kind(**given)
    message = str(caught.value)
    assert name in message
    assert repr(value) in message
    assert allowed in message


def test_the_mass_of_the_overburden_changes_inertia_and_not_the_load():
    light = Wall(0.3, 4.5, overburden_ratio=np.array([0.0, 0.5, 2.0]), eccentricity=0.05)
    heavy = replace(light, overburden_mass=1.0)
    for name in ("rigid_strength", "rigid_stiffness", "restitution_rigid", "restitution_measured"):
        np.testing.assert_array_equal(getattr(heavy, name), getattr(light, name))
    np.testing.assert_allclose(heavy.load_factor, light.load_factor, rtol=1e-14)
    np.testing.assert_allclose(heavy.rocking_onset(0.8), light.rocking_onset(0.8), rtol=1e-14)
    np.testing.assert_allclose(heavy.excitation_factor * heavy.effective_mass, heavy.mass, rtol=1e-14)
    # The energy that the bodies have, sideways and up, with c the overburden's part of F0 over 2 O.
    r, q, mass = 0.7, 1 / 225, np.array([0.0, 0.5, 2.0])
    sideways = 1 / 3 + q / 12 * (1 / r + 1 / (1 - r))
    up = q / (4 * r) + (1 - r) * q * (1 / r + 1 / (2 * (1 - r))) ** 2
    of_load = float((light.rigid_strength[2] - Wall(0.3, 4.5).rigid_strength) / (2 * light.overburden[2]))
    added = mass * of_load**2
    np.testing.assert_allclose(heavy.inertia_ratio, 1 + added / (sideways + up), rtol=1e-12)
    np.testing.assert_allclose(light.restitution_impulsive, (sideways - up) / (sideways + up), rtol=1e-12)
    assert np.isnan(heavy.restitution_impulsive).tolist() == [False, True, True]
    slower = light.frequency_parameter / heavy.frequency_parameter
    np.testing.assert_allclose(slower**2, heavy.inertia_ratio, rtol=1e-12)


@pytest.mark.parametrize("part", [-0.1, 1.2, np.nan])
def test_a_part_of_the_overburden_is_between_0_and_1(part):
    with pytest.raises(InputError, match=r"overburden_mass \(of the overburden\) is .*; it must be"):
        Wall(0.3, 4.5, overburden_ratio=1.0, overburden_mass=part)


@pytest.mark.parametrize("value", [0.0, 1.0, -0.2, 1.3, np.nan])
def test_a_hinge_outside_the_wall_is_refused(value):
    with pytest.raises(InputError, match=r"hinge_ratio \(h1/h\) is .*; it must be") as caught:
        Wall(0.3, 4.5, hinge_ratio=value)
    assert repr(value) in str(caught.value)


@pytest.mark.parametrize("made", [Wall(0.3, 4.5, overburden_ratio=1.5), Parapet(0.3, 2.0)])
@pytest.mark.parametrize("x0", [0.05, 0.5, 0.95])
def test_the_rigid_period_is_the_integral_over_a_quarter_cycle(made, x0):
    """Integral of dx/sqrt(2 (V(x0) - V(x))) under f = 1 - x, with x = x0 - s^2 to have no singular end."""
    quarter, _ = quad(lambda s: 2 / np.sqrt(2 * (1 - x0 + s * s / 2)), 0, np.sqrt(x0))
    assert float(made.rigid_period(x0)) == pytest.approx(4 * quarter / float(made.frequency_parameter), rel=1e-9)


@pytest.mark.parametrize("x0", [0.0, 1.0, float("nan")])
def test_a_rigid_wall_rocks_with_amplitudes_below_its_instability(x0):
    with pytest.raises(InputError, match="release_amplitude is"):
        Wall(0.3, 4.5).rigid_period(x0)


@pytest.mark.filterwarnings("ignore:eccentricity", "ignore:a rigid wall begins to rock at")
@pytest.mark.parametrize("overburden", [0.0, 0.3, 0.5, 1.0, 2.0, 6.0, 10.0])
@pytest.mark.parametrize("share", [-0.5, -0.2, 0.0, 0.4])
def test_the_weakest_hinge_has_the_least_strength_within_its_range(overburden, share):
    sizes = {"thickness": 0.3, "height": 4.5, "overburden_ratio": overburden, "eccentricity": 0.3 * share}
    wall = Wall(**sizes, hinge_ratio="weakest")
    least = minimize_scalar(
        lambda r: float(Wall(**sizes, hinge_ratio=r).rigid_strength), bounds=HINGE_RANGE, options={"xatol": 1e-9}
    )
    assert float(wall.hinge_ratio) == pytest.approx(least.x, abs=1e-5)
    assert float(Wall(**sizes).weakest_hinge_ratio) == float(wall.hinge_ratio)
    if share == 0.0 and overburden >= 0.6:
        upper_over_lower = np.sqrt(overburden / (2 * (1 + overburden)))
        assert (1 - wall.hinge_ratio) / wall.hinge_ratio == pytest.approx(upper_over_lower, rel=1e-14)


def test_the_weakest_hinge_is_taken_of_arrays_and_is_the_only_word():
    wall = Wall(0.3, 4.5, overburden_ratio=np.array([0.0, 1.0, 6.0]), hinge_ratio="weakest")
    np.testing.assert_allclose(wall.hinge_ratio, [0.7, 2 / 3, 1 / (1 + np.sqrt(3 / 7))], rtol=1e-12)
    named = Wall(0.3, 4.5, overburden_ratio=xr.DataArray([1.0, 6.0], dims="wall"), hinge_ratio="weakest")
    assert named.rigid_strength.dims == ("wall",)
    with pytest.raises(InputError, match="hinge_ratio is 'strongest'; it must be one of weakest, or a number"):
        Wall(0.3, 4.5, hinge_ratio="strongest")
    with pytest.raises(InputError, match="thickness is -0.3"):
        Wall(-0.3, 4.5, hinge_ratio="weakest")

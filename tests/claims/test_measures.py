"""What is measured of the datasets before a claim is judged."""

import numpy as np
import xarray as xr
from made_up_claims import A1, FREQUENCY, RELEASE, RESPONSE_LENGTH, RESTITUTION, STUDY, XI, E, row, scaled


def test_the_work_of_a_linear_damper_is_the_energy_that_a_half_cycle_loses(data):
    """u'' + 2 xi w u' + w^2 u = 0: in each half cycle the energy falls by 1 - exp(-2 pi xi/sqrt(1 - xi^2))."""
    from rockdamp.claims.mechanics import areas

    tau = np.arange(0, 9, 0.001)
    xi, w = 0.1, 2.0
    damped = w * np.sqrt(1 - xi**2)
    decay = np.exp(-xi * w * tau)
    u = decay * (np.cos(damped * tau) + xi * w / damped * np.sin(damped * tau))
    v = -(w**2) / damped * decay * np.sin(damped * tau)
    history = xr.Dataset(
        {
            name: (("damping_model", "tau"), [values])
            for name, values in (("displacement", u), ("velocity", v), ("damping_force", 2 * xi * w * v))
        },
        coords={"damping_model": ["CDC"], "tau": tau},
    )
    ratio = np.exp(-2 * np.pi * xi / np.sqrt(1 - xi**2))
    energy = 0.5 * w**2 * ratio ** np.arange(5)
    np.testing.assert_allclose(areas(history, "CDC", 8.0), energy * (1 - ratio), rtol=2e-3)


def test_the_loss_of_an_impact_is_what_the_velocities_around_it_say(data):
    from rockdamp.claims.mechanics import impact_losses

    energy = 0.5 * (RELEASE * FREQUENCY * RESTITUTION ** np.arange(5)) ** 2
    np.testing.assert_allclose(
        impact_losses(data["damping_force"], RESPONSE_LENGTH), energy * (1 - RESTITUTION**2), rtol=1e-3
    )


def test_walls_of_another_plateau_stay_out_of_the_spread_over_a1(listed, data):
    before = row(listed, data, "a1-rank")["measured"]
    scaled(A1, XI, 50.0, yield_displacement_ratio=[0.2])(data)
    assert row(listed, data, "a1-rank")["measured"] == before
    assert "a1 0.02 to 0.1:" in before and "CDC 80%" in before


def test_what_the_equations_do_not_hold_is_no_measured_zero(listed, data):
    assert "equal tau: identical by the equations" in row(listed, data, "slenderness")["measured"]
    scaled("match/slenderness", XI, 1.0005, slenderness=[2.0], damping_model=["CDC"])(data)
    told = row(listed, data, "slenderness")["measured"]
    assert "equal tau: CDC 0.05%, CDR 0%, SDR 0%" in told and "identical" in told.split("; ")[1]


def test_the_range_of_lengths_is_told_with_what_lies_between_and_what_other_releases_imply(listed, data):
    told = row(listed, data, "err-range")["measured"]
    assert "at least 3 misfits at any other whole tau studied" in told
    assert "between those next to it none at tau 8 to 8.5, at most 2 at tau 7.5 to 9" in told
    assert "6 (u0/u_ins 0.3), 8 (u0/u_ins 0.5), 12 (u0/u_ins 0.9)" in told


def test_high_and_low_e_are_the_outer_thirds_of_them(listed, data):
    """What the middle third does decides nothing, and every value of the others does."""
    before = row(listed, data, "amp-dispersion")["measured"]
    scaled(STUDY, XI, 9.0, restitution=E[2:4], release_amplitude=[0.3])(data)
    assert row(listed, data, "amp-dispersion")["measured"] == before
    for e in (*E[:2], *E[4:]):
        changed = {name: dataset.copy(deep=True) for name, dataset in data.items()}
        scaled(STUDY, XI, 9.0, restitution=[e], release_amplitude=[0.3])(changed)
        assert row(listed, changed, "amp-dispersion")["measured"] != before


def test_the_paper_s_amplitudes_are_taken_where_the_study_holds_them(listed, data):
    assert "u0/u_ins 0.3 to 0.9" in row(listed, data, "amp-cdc")["measured"]
    data[STUDY] = data[STUDY].sel(release_amplitude=[0.1, 0.5])
    assert "u0/u_ins 0.1 to 0.5" in row(listed, data, "amp-cdc")["measured"]

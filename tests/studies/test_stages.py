"""The stages between config and datasets: decays, matching of the studies, windows, fits, loops and curves."""

import copy

import numpy as np
import pytest
import yaml
from repository import ROOT

from rockdamp.equivalence.closed_form import giannini_masiani
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import MODELS, VISCOUS_MODELS
from rockdamp.storage import dataset
from rockdamp.studies import damping_loops, force_curves, polynomial_fits, response_length
from rockdamp.studies.accuracy import convergence
from rockdamp.studies.decays import describe
from rockdamp.studies.decays import study as decay_study
from rockdamp.studies.matches import match
from rockdamp.studies.settings import DecaySettings
from rockdamp.vocabulary import DEFAULT_WINDOW, STUDIES


@pytest.fixture(scope="module")
def paper():
    return yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def config(paper):
    """The paper's config with fewer values, a larger step and shorter responses."""
    small = copy.deepcopy(paper)
    small["solver"]["step"] = 0.01
    small["restitution"] = {"start": 0.74, "stop": 0.98, "step": 0.04}
    small["studies"]["amplitude"]["release_amplitude"] = [0.3, 0.5, 0.9]
    small["studies"]["slenderness"]["slenderness"] = [10, 15, 30]
    small["studies"]["overburden"]["overburden_ratio"] = [0.0, 0.5]
    small["studies"]["cracked_stiffness"]["cracked_stiffness_ratio"] = [0.02, 0.04, 0.10, 0.20]
    small["windows"] = {"start": 3, "stop": 16, "step": 1}
    return small


@pytest.fixture(scope="module")
def decays(config):
    return {name: decay_study(name, config) for name in STUDIES}


@pytest.fixture(scope="module")
def matches(config, decays):
    return {name: match(name, config, decays[name]) for name in STUDIES}


def test_the_restitution_grid_is_exact_in_decimals(paper):
    grid = DecaySettings.of(paper).restitution
    assert list(grid) == [round(0.70 + 0.01 * i, 2) for i in range(29)]


@pytest.mark.parametrize("name", STUDIES)
def test_decay_peaks_follow_the_energy_of_each_impact(name, decays, config):
    """V(x_n) = e^{2n} V(x0): the fifth peak, to the second order of a step of 0.01."""
    study, data = describe(name, config), decays[name]
    for i in range(study.values.size):
        curve = study.curve.map(lambda p, i=i: p[i])
        for j, e in enumerate(data["restitution"].values):
            u = np.abs(data["displacement"].values[i, j])
            peaks = np.flatnonzero((u[1:-1] >= u[:-2]) & (u[1:-1] > u[2:])) + 1
            expected = float(curve.energy(study.release_amplitude[i])) * e ** (2 * 3)
            if peaks.size >= 3:
                assert float(curve.energy(u[peaks[2]])) == pytest.approx(expected, rel=0.02)


def test_walls_of_the_same_curve_decay_alike_in_tau(decays):
    for name in ("slenderness", "overburden"):
        values = decays[name]["displacement"].values
        assert np.array_equal(values, np.broadcast_to(values[:1], values.shape))


def test_a_higher_plateau_than_the_cracked_stiffness_allows_is_replaced(decays):
    plateau = decays["cracked_stiffness"]["plateau_ratio"].values
    np.testing.assert_array_equal(plateau, [0.85, 0.85, 0.85, 0.75])


@pytest.mark.parametrize("name", STUDIES)
def test_the_matched_error_is_what_the_definition_gives(name, matches, config):
    match = matches[name]
    assert float(match["steps"] * match["step"]) == pytest.approx(float(match["window"]))
    np.testing.assert_allclose(match["rms_error"], np.sqrt(match["error"] / match["steps"]))
    assert (match["local_minima"] >= 1).all()
    assert (match["damping_ratio_uncertainty"] < 0.03 * match["damping_ratio"]).all()


def test_damping_grows_as_restitution_falls(matches):
    for matched in matches.values():
        assert (matched["damping_ratio"].diff("restitution") < 0).all()


def test_equal_lengths_in_tau_make_walls_equal_and_equal_seconds_do_not(matches):
    for name, parameter in (("slenderness", "slenderness"), ("overburden", "overburden_ratio")):
        match = matches[name]
        assert float((match["damping_ratio"].max(parameter) - match["damping_ratio"].min(parameter)).max()) == 0.0
        fixed = match["damping_ratio_fixed_seconds"]
        assert float((fixed.max(parameter) - fixed.min(parameter)).max()) > 1e-4


def test_the_reference_wall_is_the_same_at_a_fixed_length_in_seconds(matches, config):
    match = matches["slenderness"].sel(slenderness=config["wall"]["slenderness"])
    np.testing.assert_allclose(match["damping_ratio_fixed_seconds"], match["damping_ratio"], rtol=1e-6)


def test_studies_agree_where_they_meet(matches):
    """Every study holds the reference wall: a1 = 0.04, released at 0.5."""
    values = [
        matches["amplitude"]["damping_ratio"].sel(release_amplitude=0.5).values,
        matches["slenderness"]["damping_ratio"].sel(slenderness=15).values,
        matches["overburden"]["damping_ratio"].sel(overburden_ratio=0).values,
        matches["cracked_stiffness"]["damping_ratio"].sel(cracked_stiffness_ratio=0.04).values,
    ]
    for other in values[1:]:
        np.testing.assert_allclose(other, values[0], rtol=1e-6)


def test_windows_agree_with_the_match_at_its_window(config, decays, matches):
    """Both find the same minima; the match then follows them to a finer step, which moves them a little."""
    found = response_length.windows(config, decays["amplitude"])
    window = float(matches["amplitude"]["window"])
    here = found["damping_ratio"].sel(window=window).transpose("damping_model", "restitution")
    np.testing.assert_allclose(here, matches["amplitude"]["damping_ratio"].sel(release_amplitude=0.5), rtol=0.02)


def test_the_default_window_is_the_one_that_the_paper_implies(paper):
    """The inference on the paper's grid of e, over the windows that hold its minimum, at twice the step."""
    config = copy.deepcopy(paper)
    config["solver"]["step"] = 2 * paper["solver"]["step"]
    config["studies"]["amplitude"]["release_amplitude"] = [paper["release_amplitude"]]
    config["windows"] = {**paper["windows"], "stop": 30}
    found = response_length.windows(config, decay_study("amplitude", config))
    assert float(found["inferred_window"]) == DEFAULT_WINDOW
    flag = found["cdr_lowest_in_paper_range"].sel(window=DEFAULT_WINDOW)
    assert int(flag) == (int(found["misclassified"].min()) == 0)


def test_a_built_windows_dataset_infers_the_default_window():
    path = ROOT / "results/windows.nc"
    if not path.exists():
        pytest.skip("results/windows.nc is not built")
    assert float(dataset.open(path)["inferred_window"]) == DEFAULT_WINDOW


def test_misfits_are_counted_against_the_papers_range():
    import xarray as xr

    e = np.array([0.75, 0.80, 0.91, 0.95])
    lowest = {"perfect": ["SDR", "CDR", "CDR", "SDR"], "never": ["SDR"] * 4, "always": ["CDR"] * 4}
    error = np.ones((3, 4, 4))
    for w, models in enumerate(lowest.values()):
        for i, model in enumerate(models):
            error[w, i, VISCOUS_MODELS.index(model)] = 0.5
    data = xr.Dataset(
        {"error": (("window", "restitution", "damping_model"), error)},
        coords={"window": [1.0, 2.0, 3.0], "restitution": e, "damping_model": list(VISCOUS_MODELS)},
    )
    assert response_length.misclassified(data).values.tolist() == [0, 2, 2]
    assert response_length.infer(data) == 1.0
    flags = response_length.flags(data)
    assert flags["cdr_lowest_in_paper_range"].values.tolist() == [1, 0, 0]
    assert flags["secant_below_constant"].values.tolist() == [0, 0, 0]


def test_a_quadratic_is_fitted_exactly(matches, config):
    match = matches["cracked_stiffness"].copy(deep=True)
    e = match["restitution"]
    match["damping_ratio"] = (0.3 - 0.4 * e + 0.1 * e**2).broadcast_like(match["damping_ratio"])
    fit = polynomial_fits.fit(config, match)
    np.testing.assert_allclose(fit["coefficient"], np.broadcast_to([0.3, -0.4, 0.1], fit["coefficient"].shape))
    np.testing.assert_allclose(fit["largest_residual"], 0, atol=1e-14)


def test_fits_keep_to_the_reference_plateau_and_match_numpy(matches, config):
    fit = polynomial_fits.fit(config, matches["cracked_stiffness"])
    assert fit["cracked_stiffness_ratio"].values.tolist() == [0.02, 0.04, 0.10]
    e = fit["restitution"].values
    one = fit.sel(damping_model="SDR", cracked_stiffness_ratio=0.04)
    expected, covariance = np.polyfit(e, one["damping_ratio"].values, 2, cov=True)
    np.testing.assert_allclose(one["coefficient"], expected[::-1], rtol=1e-8)
    np.testing.assert_allclose(one["coefficient_covariance"], covariance[::-1, ::-1], rtol=1e-6)
    np.testing.assert_allclose(fit["giannini_masiani"], giannini_masiani(e))
    residual = np.abs(one["damping_ratio"] - one["damping_ratio_fit"])
    assert float(one["largest_residual"]) == pytest.approx(float(residual.max()))


def test_the_table_of_coefficients_holds_every_polynomial_once(matches, config):
    fit = polynomial_fits.fit(config, matches["cracked_stiffness"])
    table = polynomial_fits.table(fit)
    assert len(table) == fit.sizes["damping_model"] * fit.sizes["cracked_stiffness_ratio"]
    row = table[(table.damping_model == "CDR") & (table.cracked_stiffness_ratio == 0.10)].iloc[0]
    own = fit["coefficient"].sel(damping_model="CDR", cracked_stiffness_ratio=0.10).values
    assert [row.c0, row.c1, row.c2] == own.tolist()


def test_loops_hold_the_force_of_each_damper(config):
    found = damping_loops.loops(config)
    curve = TrilinearCurve(**config["curve"])
    xi = float(found["damping_ratio"].sel(damping_model="SDR"))
    one = found.sel(damping_model="SDR")
    secant = curve.secant(one["displacement"].values)
    expected = 2 * xi * secant / curve.initial_frequency * one["velocity"].values
    np.testing.assert_allclose(one["damping_force"], expected, rtol=1e-9, atol=1e-12)
    assert (found["damping_force"].sel(damping_model="CR") == 0).all()
    law = found["damping_ratio_law"]
    assert (law.sel(viscous_model="CDR")[1:] == 1).all()
    np.testing.assert_allclose(law.sel(viscous_model="SDR"), found["frequency_ratio"])
    np.testing.assert_allclose(law.sel(viscous_model="CDC")[1:], 1 / found["frequency_ratio"][1:])


def test_the_stiff_tri_linear_wall_rocks_like_a_rigid_one(config):
    """Fig. 4a: the first half cycle of the nearly rigid curve against the slender limit, within its own 1 %."""
    found = damping_loops.loops(config)["rocking_displacement"].sel(tau=slice(0, 2.5))
    assert float(np.abs(found[0] - found[1]).max()) < 0.02


def test_curves_are_tabulated_on_the_bi_linear_law_or_below(config):
    found = force_curves.mechanism(config)
    rigid = found["force"].sel(curve_name="bi-linear")
    assert (found["force"] <= rigid + 1e-12).all()
    drawn = found.sel(curve_name="severe")
    assert (float(drawn["plateau_ratio"]), float(drawn["cracked_stiffness_ratio"])) == (0.5, 0.2)


@pytest.fixture(scope="module")
def orders(paper):
    return convergence.orders(paper)


@pytest.mark.parametrize("model", MODELS)
@pytest.mark.parametrize("excitation", ["free", "forced"])
def test_the_default_scheme_is_second_order_for_every_damper(orders, model, excitation):
    order = float(orders["order"].sel(scheme="newmark", damping_model=model, excitation=excitation))
    assert order == pytest.approx(2.0, abs=0.1)


def test_the_printed_scheme_is_first_order_but_for_a_constant_coefficient(orders):
    paper = orders.sel(scheme="paper")
    assert (np.abs(paper["order"].sel(damping_model="CDC") - 2) < 0.1).all()
    # C frozen over the step is a small first-order term, which takes over from the second-order ones at fine steps.
    frozen = paper["finest_order"].sel(damping_model=["CR", "CDR", "SDR", "ECD"])
    assert ((frozen > 0.75) & (frozen < 1.5)).all()

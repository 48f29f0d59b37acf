"""What is recommended: the least error and all that no study tells apart from it, when it holds, and what it misses."""

import made_up_earthquakes as made_up
import numpy as np
import pytest
import xarray as xr
from configs import configured

from rockdamp.equivalence.closed_form import damping_ratio_energy
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.storage import dataset
from rockdamp.studies.recommendation import MULTIPLE, TOLERANCE, holds, recommend, under_earthquakes
from rockdamp.vocabulary import VISCOUS_MODELS

CURVE = TrilinearCurve(0.04, 0.85)
E = [0.8, 0.85, 0.9]


def marked(advice, name):
    """The dampers and sources at which a variable is 1."""
    values = advice[name].stack(choice=["damping_model", "damping_ratio_source"])
    return [tuple(choice) for choice in values["choice"].values[values.values == 1]]


def at_middle(compared):
    advice = under_earthquakes(compared).sel(restitution=0.85)
    (least,) = marked(advice, "least_error")
    return least, [choice for choice in marked(advice, "not_told_apart") if choice != least]


def scaled(factor, **where):
    """The made-up comparison with the errors at some coordinates times a factor."""
    compared = made_up.comparison()
    chosen = xr.ones_like(compared["log_error"], dtype=bool)
    for dim, label in where.items():
        chosen = chosen & (compared[dim] == label)
    return made_up.with_excess(compared.assign(log_error=compared["log_error"] * xr.where(chosen, factor, 1.0)))


# --- which damper -----------------------------------------------------------------------------------------------------


def test_the_least_error_is_recommended_and_those_that_err_no_more_with_certainty_are_as_good():
    compared = made_up.comparison()
    least, near = at_middle(compared)
    # CDR errs 0.100, 0.102 and 0.104, ECD 0.110, 0.112 and 0.114; the excess is uncertain by 0.011.
    assert least == ("CDR", "polynomial")
    assert near == [("CDR", "least error"), ("CDR", "closed form"), ("ECD", "polynomial")]
    advice = under_earthquakes(compared)
    assert marked(advice, "recommended") == [least] and marked(advice, "as_good") == near


def test_errors_whose_intervals_overlap_are_told_apart_where_their_difference_is_certain():
    compared = made_up.comparison()
    one, other = (compared["log_error_interval"].isel(band=0).sel(damping_model=m) for m in ("CDR", "ECD"))
    assert (one.sel(bound="upper") > other.sel(bound="lower")).any()
    certain = compared["log_error_excess"].expand_dims(bound=compared["bound"]).transpose(..., "bound")
    assert at_middle(compared.assign(log_error_excess_interval=certain)) == (("CDR", "polynomial"), [])


def test_an_error_that_is_not_known_is_neither_the_least_nor_tied_with_it():
    compared = made_up.comparison()
    unknown = (compared["damping_model"] == "CDR") & (compared["damping_ratio_source"] == "polynomial")
    least, near = at_middle(made_up.with_excess(compared.assign(log_error=compared["log_error"].where(~unknown))))
    assert least == ("CDR", "least error")
    assert near == [("CDR", "closed form"), ("ECD", "polynomial"), ("ECD", "least error")]


def test_errors_over_fewer_walls_are_not_ranked_but_may_be_as_good():
    """The polynomials err least, by far, but do not reach one wall: the least is that of the sources that do."""
    compared = scaled(0.9, damping_model="CDR", damping_ratio_source="polynomial")
    assert at_middle(compared)[0] == ("CDR", "polynomial")
    missing = (compared["wall"] == compared["wall"][0]) & (compared["damping_ratio_source"] == "polynomial")
    fewer = made_up.with_excess(compared.assign(pooled=compared["pooled"].where(~missing, 0)))
    least, near = at_middle(fewer)
    assert least == ("CDR", "least error") and ("CDR", "polynomial") in near
    assert marked(under_earthquakes(fewer), "recommended") == [("CDR", "least error")]


def test_of_a_damper_with_an_exact_ratio_the_exact_one_is_recommended_where_no_other_errs_less_with_certainty():
    compared = scaled(0.2, damping_model="ECD")
    errors = compared["log_error"].isel(band=0).sel(damping_model="ECD").mean("restitution")
    assert errors.idxmin("damping_ratio_source") == "polynomial"
    assert marked(under_earthquakes(compared), "recommended") == [("ECD", "closed form")]
    worse = scaled(0.2, damping_model="ECD", damping_ratio_source="polynomial")
    assert marked(under_earthquakes(worse), "recommended") == [("ECD", "polynomial")]


def test_no_damper_is_recommended_where_each_e_has_another_or_one_has_none():
    of_each = under_earthquakes(scaled(0.1, damping_model="SDR", restitution=0.8))
    unknown = under_earthquakes(scaled(np.nan, restitution=0.8))
    for advice in (of_each, unknown):
        assert marked(advice, "recommended") == marked(advice, "as_good") == []
    assert marked(unknown.sel(restitution=0.8), "not_told_apart") == []


# --- when, and when not -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("error", "own", "well"),
    [(0.2, 0.1, True), (0.21, 0.1, False), (0.1, 0.001, True), (0.11, 0.001, False), (np.nan, 0.1, False)],
)
def test_a_damper_holds_within_twice_the_sensitivity_of_restitution_or_a_tenth(error, own, well):
    assert (MULTIPLE, TOLERANCE) == (2.0, 0.10)
    assert bool(holds(xr.DataArray(error), xr.DataArray(own))) is well


@pytest.fixture
def others():
    """ECD of each order under earthquakes and in free decay: the numbers that the recommendation takes of them."""
    orders = xr.Dataset(
        {"recommended_order": ("change", [4.0, 8.0, 0.0]), "restitution_change": 0.02, "records": 7},
        coords={"change": ["e", "loss", "tests"]},
    )
    by_order = xr.Dataset(
        {"shown_damping_force": (("order", "tau"), [[-0.3, 0.1], [-1.2, 0.4], [-2.0, 0.5]])},
        coords={"order": [0.0, 8.0, 32.0]},
    )
    return orders, by_order


@pytest.fixture
def config():
    return configured()


def test_the_dataset_is_what_the_glossary_says_and_holds_the_numbers_of_each_study(config, others):
    advice = recommend(config, made_up.comparison(), *others)
    dataset.check(advice, "recommendation")
    assert (float(advice["recommended_order"]), int(advice["records"])) == (8.0, 7)
    for model in VISCOUS_MODELS:
        ratio = damping_ratio_energy(CURVE, model, np.array(E), 0.5)
        np.testing.assert_allclose(advice["damping_ratio_energy"].sel(damping_model=model), ratio)
    np.testing.assert_allclose(advice["sensitivity"].isel(band=0), 0.07)
    np.testing.assert_allclose(advice["near_collapse_sensitivity_to_restitution"], 0.06 * 1.5)
    assert float(advice["crossing_force"]) == 1.2  # of the order nearest to the recommended one, whatever its sign


def test_a_damper_stands_beside_the_smaller_of_what_a_lower_and_a_higher_e_do(config, others):
    """Typical size, tail and root mean square; and false answers beside the e that makes each."""
    compared = made_up.comparison()
    variation = compared["variation"]
    of_e = variation.isin(["lower e", "higher e"])
    for name, low, high in (("log_error", 0.06, 0.07), ("log_error_median", 0.03, 0.02), ("log_error_90", 0.05, 0.09)):
        sides = xr.where(variation == "lower e", low, high)
        values = xr.zeros_like(compared[f"varied_{name}"])
        compared[f"varied_{name}"] = values + xr.where(of_e, sides, 0.001)
    for name in ("safe", "collapse"):
        rate = xr.where(variation == "lower e", 0.3, xr.where(variation == "higher e", 0.1, 0.9))
        compared[f"varied_false_{name}_rate"] = xr.zeros_like(compared[f"varied_false_{name}_rate"]) + rate
    advice = recommend(config, compared, *others)
    for ending, smaller in (("", 0.06), ("_median", 0.02), ("_90", 0.05)):
        np.testing.assert_allclose(advice[f"sensitivity_to_restitution{ending}"], smaller)
        np.testing.assert_allclose(advice[f"near_collapse_sensitivity_to_restitution{ending}"], smaller)
    np.testing.assert_allclose(advice["sensitivity_false_safe_rate"], 0.3)
    np.testing.assert_allclose(advice["sensitivity_false_collapse_rate"], 0.1)

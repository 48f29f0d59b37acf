"""Numbers in the sentences of the documents, outside of the tables, against the datasets of the full build."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from pages import assert_stated, read_full
from repository import ROOT
from scipy.stats import chi2

from rockdamp.constants import (
    RECOMMENDED_SOURCE,
    RELEASES,
    SMALL_RELEASE_OVERSTATES,
    STUDIES,
    VISCOUS_MODELS,
)

ACCURACY, EARTHQUAKES = "docs/accuracy.md", "docs/earthquakes.md"
MEASURED, THEORY = "docs/measured.md", "docs/theory.md"


def compared(source=RECOMMENDED_SOURCE):
    """Errors of each damper in per cent, all bands together, by e."""
    study = read_full("comparison").sel(
        band=0, damping_ratio_source=source, damping_model=list(VISCOUS_MODELS)
    )
    return (
        100
        * study[
            ["log_error_median", "missed_collapse_rate", "median_ratio", "median_ratio_interval"]
        ]
    )


def test_dampers_under_earthquakes():
    errors = compared()
    median, missed = (
        errors["log_error_median"].sel(restitution=0.85),
        errors["missed_collapse_rate"],
    )
    words = r"under restitution by ([\d.]+) % in the median, and it misses ([\d.]+) % .*? is ([\d.]+) %, and ([\d.]+) %"
    values = (one for model in ("BAND", "CDR") for one in (median, missed.sel(restitution=0.85)))
    models = ("BAND", "BAND", "CDR", "CDR")
    assert_stated(
        EARTHQUAKES,
        words,
        *(float(v.sel(damping_model=m)) for v, m in zip(values, models, strict=True)),
    )
    assert (
        errors["log_error_median"].sel(damping_model=["CDC", "CDR", "SDR"]).argmin("damping_model")
        == 1
    ).all()
    ratio = errors["median_ratio"].sel(restitution=0.85)
    bounds = errors["median_ratio_interval"].sel(restitution=0.85, damping_model="CDC") - 100
    assert_stated(EARTHQUAKES, r"\*\*CDC\*\* is (\d) % to (\d) % high", *bounds.values)
    low = 100 - ratio.sel(damping_model=["ECD", "SDR"])
    assert_stated(EARTHQUAKES, r"peaks that are (\d) % to (\d) % too low", *low.values)
    closed = compared("closed form")["log_error_median"].sel(restitution=0.85, damping_model="CDR")
    words = r"median error of the peaks with CDR from ([\d.]+) % to ([\d.]+) %"
    assert_stated(ACCURACY, words, float(median.sel(damping_model="CDR")), float(closed))


# Peaks [mm] of two nominally identical walls, second-hand: docs/earthquakes.md names the source.
TWIN_PEAKS = {
    "first": [0.30, 0.41, 1.24, 2.57, 8.48, 16.37, 3.65, 13.15, 29.48],
    "second": [0.11, 0.39, 0.85, 1.93, 5.19, 10.11, 2.38, 5.26, 7.58],
}


@pytest.mark.parametrize("page", [ACCURACY, EARTHQUAKES])
def test_twin_walls_differ_more_than_dampers(page):
    first, second = TWIN_PEAKS.values()
    difference = np.abs(np.log(np.divide(first, second)))
    errors = compared()["log_error_median"].sel(restitution=0.85) / 100
    band, cdc = errors.sel(damping_model=["BAND", "CDC"]).values
    if page == ACCURACY:
        words = (
            r"differed by ([\d.]+) in abs\(ln r\).*? from restitution by ([\d.]+) and ([\d.]+) \("
        )
        assert_stated(page, words, np.median(difference), band, cdc)
    else:
        words = r"differ by ([\d.]+) to ([\d.]+) in abs\(ln r\), ([\d.]+) in the median"
        assert_stated(page, words, difference.min(), difference.max(), np.median(difference))
        assert_stated(page, r"here BAND has ([\d.]+) and CDC ([\d.]+)\.", band, cdc)


def test_error_against_force():
    study = read_full("order")
    median, force = study["log_error_median"], study["crossing_force"].sel(wall="paper")
    at = {"restitution": 0.85}
    changed = 100 * float(median.sel(damper=["e - 0.01", "e + 0.01"], **at).mean())
    assert_stated(EARTHQUAKES, r"change of e by 0.01 makes a difference of (\d) %", changed)
    half, end = (
        100 * float(median.sel(damper=name, **at)) for name in ("half step", "end of step")
    )
    words = r"CR changes by ([\d.]+) % in the median\. .*? it changes by ([\d.]+) %"
    assert_stated(EARTHQUAKES, words, half, end)
    shown = ["ECD", "ECD16", "ECD64", "BAND0.4", "BAND0.2", "BAND0.1"]
    larger, worse = (one.sel(restitution=0.75) / one.sel(at) for one in (force, median))
    ends = float(worse.sel(damper=shown).min()), float(worse.sel(damper=shown).max())
    words = r"forces are ([\d.]+) times as large, and the medians of BAND and ECD ([\d.]+) to ([\d.]+) times"
    assert_stated(EARTHQUAKES, words, float(larger.sel(damper="BAND0.2")), *ends)
    for e in (0.75, 0.85):
        for band, ecd in (("BAND0.4", "ECD16"), ("BAND0.2", "ECD64")):
            for measure in (force, median, study["log_error_90"]):
                assert float(measure.sel(damper=band, restitution=e)) < float(
                    measure.sel(damper=ecd, restitution=e)
                )
    bands = [
        name
        for name in study["damper"].values
        if name.startswith("BAND") and float(name[4:]) <= 0.4
    ]
    for name in ("log_error_median", "log_error_90"):
        assert (
            study[name].sel(damper=bands).max("damper")
            < study[name].sel(damper=["e - 0.01", "e + 0.01"]).min()
        ).all()
    falling = median.sel(damper=["BAND0.6", *bands]).diff("damper")
    assert (falling < 0).all()


def test_amplitude_at_which_e_is_meant():
    ratio = read_full("loss_law")["median_intensity_ratio"].sel(wall="all")
    over = 100 * (1 / ratio - 1)
    small, good = over.sel(reference_amplitude=0.1), over.sel(reference_amplitude=[0.3, 0.5])
    words = r"overstates the median intensity of collapse by (\d+) to (\d+) % with g = ([\d.]+) to ([\d.]+\d)"
    values = [
        float(end)
        for end in (small.min(), small.max(), ratio["loss_exponent"][0], ratio["loss_exponent"][-1])
    ]
    assert_stated(EARTHQUAKES, words, *values)
    assert [float(one) for one in re.findall(r"[\d.]+", SMALL_RELEASE_OVERSTATES)] == pytest.approx(
        values, abs=0.51
    )
    assert float(abs(good).max()) < 5 and RELEASES == "0.3 to 0.5 u_ins"


def test_largest_cost_of_an_assumption():
    floors = read_full("supports")["median_intensity_ratio"].sel(wall="all")
    assert_stated(ACCURACY, r"change results by up to (\d+) %", 100 * (1 - float(floors.min())))


def test_response_length():
    study = read_full("response_lengths")
    wrong, near = study["misclassified"], study["near_misclassified"]
    holds = near["near_response_length"].values[near.values == 0]
    released = study["inferred_response_length_of_release"]
    others = wrong.drop_sel(response_length=8)
    assert int(wrong.sel(response_length=8)) == 0
    assert_stated(
        ACCURACY, r"at (\d) or more of the (\d+) e", int(others.min()), study.sizes["restitution"]
    )
    assert_stated(ACCURACY, r"steps of 0\.1, only ([\d.]+) and ([\d.]+) agree\.", *holds)
    assert_stated(
        ACCURACY, r"best length is (\d+) to (\d+)", float(released.min()), float(released.max())
    )
    fails = study["misclassified_of_release"]
    assert fails["release_amplitude"].values[fails.values == 0].tolist() == [0.5]


def test_uncertainty_of_damping_ratios():
    studies = (read_full(f"match/{study}") for study in STUDIES)
    parts = (100 * one["damping_ratio_uncertainty"] / one["damping_ratio"] for one in studies)
    uncertainty = np.concatenate([part.values.ravel() for part in parts])
    assert uncertainty.max() < 0.1 and np.median(uncertainty) == pytest.approx(0.003, rel=0.1)
    lengths, exact = (
        read_full("response_lengths"),
        read_full("match/amplitude").sel(release_amplitude=0.5),
    )
    lengths = lengths.sel(response_length=float(exact["response_length"]))
    bound = lengths["damping_ratio_uncertainty"] + exact["damping_ratio_uncertainty"]
    within = abs(lengths["damping_ratio"] - exact["damping_ratio"]) <= bound
    assert_stated(ACCURACY, r"(\d+) % of its ratios agree", 100 * float(within.mean()))


def test_errors_of_the_polynomials():
    study = read_full("equivalence")
    paper = 100 * study["largest_relative_error"].max("yield_displacement_ratio")
    cdc = paper.sel(damping_model="CDC", restitution_range=[0.96, 1.0])
    assert_stated(
        ACCURACY,
        r"is ([\d.]+) % up to e = 0.96 and (\d+) % above, both for CDC",
        *cdc.values,
    )
    assert (paper.sel(restitution_range=[0.96, 1.0]) <= cdc).all()
    in_delta = 100 * float(study["delta_largest_relative_error"].max())
    assert_stated(ACCURACY, r"its largest error is ([\d.]+) %", in_delta)


def test_histories_solved_again():
    check = read_full("earthquakes/check").set_index(stratum="stratum")
    converged = check.drop_sel(stratum="unconverged")
    assert (
        float(converged["otherwise_share"].max()) == 0
        and float(converged["beyond_bound_share"].max()) == 0
    )
    assert_stated(
        ACCURACY,
        r"agree; ([\d.]+) % are\.",
        100 * float(read_full("comparison")["converged_share"]),
    )
    differ = [
        100 * float(converged[name].max()) for name in ("largest_difference", "median_difference")
    ]
    assert_stated(
        ACCURACY, r"differ by at most ([\d.]+) %, in the median by ([\d.]+) % or less", *differ
    )
    otherwise = 100 * float(check["otherwise_share"].sel(stratum="unconverged"))
    assert_stated(ACCURACY, r"depend on the step, (\d) % differ", otherwise)


def test_closed_form():
    study = read_full("amplitude")

    def off(measure, model, e):
        one = study.sel(damping_model=model, restitution=e)
        return 100 * float(abs(one["damping_ratio_energy"] / one[measure] - 1).max())

    words = r"within ([\d.]+) % for CDR .*? and within (\d) % for SDR at e = 0.85"
    assert_stated(
        THEORY,
        words,
        off("damping_ratio_peaks", "CDR", 0.75),
        off("damping_ratio_peaks", "SDR", 0.85),
    )
    words = r"up to (\d+) % low for CDR and (\d+) % high for SDR"
    assert_stated(
        THEORY, words, off("damping_ratio", "CDR", 0.75), off("damping_ratio", "SDR", 0.75)
    )


def test_measured_trials():
    impacts = pd.read_csv(ROOT / "data/measured/limestone-free-rocking.csv", comment="#")
    used = impacts[impacts["duplicate_of_trial"].isna()]
    trials = used.groupby(["group", "trial"]).ngroups
    thousands, rest = divmod(len(used), 1000)
    assert_stated(
        MEASURED,
        r"are (\d+) trials of twelve .*? with (\d+) (\d+) measured impacts",
        trials,
        thousands,
        rest,
    )
    study = read_full("measured_rocking")
    likelihood = study["log_likelihood"]
    twice = 2 * (likelihood.sel(damping_model="power law") - likelihood.sel(damping_model="CR"))
    p = xr.apply_ufunc(chi2.sf, twice, 1)
    words = r"\(p = ([\d.]+) and ([\d.]+)\)\. With 8 impacts p is ([\d.]+), with 6 it is ([\d.]+)\."
    assert_stated(MEASURED, words, *p.sel(impacts_used=[10, 14, 8, 6]).values)
    assert (likelihood.argmin("damping_model") == 1).all()  # CDC
    names = (
        "deviation_within",
        "deviation_between",
        "first_ratio_deviation_within",
        "noise",
        "alternation",
    )
    words = (
        r"deviation of ([\d.]+), .*? one of ([\d.]+), "
        r".*? scatters by ([\d.]+) .*? this, ([\d.]+) is .*? and ([\d.]+) a"
    )
    assert_stated(MEASURED, words, *(float(study[name]) for name in names))
    assert_stated(
        MEASURED,
        r"e to Housner's value is ([\d.]+)\.",
        float(study["restitution_over_housner_mean"]),
    )

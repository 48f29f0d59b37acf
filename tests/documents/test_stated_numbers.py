"""Numbers in the words of the documents, outside of the tables, against the built datasets."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr
from repository import ROOT

from rockdamp.constants import RELEASES, SMALL_RELEASE_OVERSTATES, STUDIES
from rockdamp.storage import dataset

PAGES_THAT_ASK_FOR_E = ("choose-inputs", "many-walls", "the-damper-in-your-program", "your-test", "your-wall")


def built(name):
    path = ROOT / f"results/{name}.nc"
    if not path.exists():
        pytest.skip("the full results are not built")
    return dataset.read(path)


def stated(page, pattern):
    """The numbers in the brackets of a pattern, which stands once on a page."""
    text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
    (found,) = re.findall(pattern, text)
    return [float(number) for number in (found if isinstance(found, tuple) else (found,))]


def test_the_closed_form_is_within_what_is_stated():
    study = built("amplitude")

    def off(measure, model, e):
        one = study.sel(damping_model=model, restitution=e)
        return 100 * float(np.abs(one["damping_ratio_energy"] / one[measure] - 1).max())

    cdr, sdr = stated("docs/theory.md", r"For CDR the closed form is within (\d) % .*?, for SDR within (\d) % at 0.85")
    assert cdr - 1 < max(off("damping_ratio_peaks", "CDR", e) for e in (0.75, 0.85, 0.95)) <= cdr
    assert sdr - 2 < max(off("damping_ratio_peaks", "SDR", e) for e in (0.85, 0.95)) <= sdr
    low, high = stated("docs/theory.md", r"up to (\d+) % low for CDR and up to (\d+) % high for SDR")
    assert low - 1 < off("damping_ratio", "CDR", 0.75) <= low and high - 1 < off("damping_ratio", "SDR", 0.75) <= high


def test_damping_ratios_of_the_studies_are_as_certain_as_is_stated():
    bound, most = stated("docs/accuracy.md", r"are certain to ([\d.]+) %, and most to the resolution .*?, ([\d.]+) %")
    parts = []
    for study in STUDIES:
        matched = built(f"match/{study}")
        parts.append((100 * matched["damping_ratio_uncertainty"] / matched["damping_ratio"]).values.ravel())
    certain = np.concatenate(parts)
    assert certain.max() <= bound and (certain <= most * (1 + 1e-9)).mean() > 0.5


def test_damping_ratios_against_the_length_of_the_response_lie_within_their_own_uncertainty():
    lengths, matched = built("response_lengths"), built("match/amplitude")
    at = {"response_length": float(matched["response_length"])}
    exact = matched.sel(release_amplitude=0.5)
    off = np.abs(lengths["damping_ratio"].sel(at) - exact["damping_ratio"])
    bound = lengths["damping_ratio_uncertainty"].sel(at) + exact["damping_ratio_uncertainty"]
    words = r"response_lengths.nc`.*? hold at least (\d+) % of the differences .*?: of BAND (\d+) %, of CDC (\d+) %"
    share, *by_model = stated("docs/accuracy.md", words)
    within = 100 * (off <= bound)
    assert float(within.mean()) >= share
    least = xr.full_like(within.mean("restitution"), 100.0)
    least.loc[{"damping_model": ["BAND", "CDC"]}] = by_model
    assert (within.mean("restitution").round() >= least).all()


def test_what_small_releases_cost_is_that_of_the_table_of_the_law():
    """The table is made from results/loss_law.nc, and a test of the tables keeps it so."""
    least, most, small, large = map(float, re.findall(r"[\d.]+", SMALL_RELEASE_OVERSTATES))
    for overstated, exponent in ((least, small), (most, large)):
        ratio, *others = (
            stated("docs/earthquakes.md", rf"\| {exponent} \| {at} u_ins \| ([\d.]+) ")[0] for at in (0.1, 0.3, 0.5)
        )
        assert round(100 * (1 / ratio - 1)) == overstated
        assert all(abs(1 / other - 1) <= 0.05 for other in others) and RELEASES == "0.3 to 0.5 u_ins"
    pages = ("README.md", "docs/earthquakes.md", *(f"docs/howto/{name}.md" for name in PAGES_THAT_ASK_FOR_E))
    for page in pages:
        told = stated(
            page, r"0\.1 u_ins (?:it )?overstates the [a-z ]+ by (\d+) to (\d+) % with g = ([\d.]+) to ([\d.]+\d)"
        )
        assert told == [least, most, small, large]


def test_the_measured_page_counts_the_trials_that_are_used_and_their_impacts():
    impacts = pd.read_csv(ROOT / "data/measured/limestone-free-rocking.csv", comment="#")
    used = impacts[impacts["duplicate_of_trial"].isna()]
    words = r"are (\d+) trials of twelve .*? with (\d+)\s(\d+) measured impacts"
    trials, thousands, rest = stated("docs/measured.md", words)
    assert trials == used.groupby(["group", "trial"]).ngroups and 1000 * thousands + rest == len(used)


def test_the_noise_in_one_impact_s_scatter_is_that_of_the_table_of_the_trials():
    noise = stated("docs/measured.md", r"\| noise of one ratio in it: .*? \| ([\d.]+) \|")
    noise += stated("docs/measured.md", r"\| odd and even impacts that differ: .*? \| ([\d.]+) \|")
    (scatter,) = stated("docs/measured.md", r"\| first ratios .*? from trial to trial \| ([\d.]+) \|")
    low, high, *told = stated(
        "docs/assumptions.md",
        r"(0\.03) to (0\.04), .{0,40}?(0\.01\d) of noise of the ratio(?: in it)?, and (0\.01\d) of odd and even",
    )
    assert told == noise and low <= scatter <= high

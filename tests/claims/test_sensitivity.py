"""The sensitivity of the verdicts, as data/claims.yaml states it, by the full results."""

import numpy as np
import pytest
from pages import read_full
from repository import ROOT

from rockdamp import claims
from rockdamp.claims.judgement import (
    A1,
    MODELS,
    RELEASE,
    is_largest,
    is_smallest,
    low_over_high_restitution,
    mean_spread,
    spread,
)
from rockdamp.claims.match_errors import matched_error
from rockdamp.claims.ratios import ratios

CLAIMS = {claim["id"]: claim for claim in claims.read(ROOT / "data/claims.yaml")}
TURNS = [
    (name, limit, value)
    for name, claim in CLAIMS.items()
    for limit, values in claim.get("turns", {}).items()
    for value in values
]


class FullResults(dict):
    """Datasets of the full build, read at their first use."""

    def __missing__(self, name):
        self[name] = read_full(name)
        return self[name]


@pytest.fixture(scope="module")
def data():
    return FullResults()


@pytest.mark.parametrize(("name", "limit", "value"), TURNS)
def test_verdict_turns_at_the_stated_limit(data, name, limit, value):
    limits = CLAIMS[name]["limits"]
    lower = claims.JUDGES[name](data, limits | {limit: 0.98 * value})
    higher = claims.JUDGES[name](data, limits | {limit: 1.02 * value})
    assert lower.parts != higher.parts


def test_amplitude_of_cdr_over_all_releases(data):
    spreads = mean_spread(ratios(data["match/amplitude"]), RELEASE)
    words = f"{100 * float(spreads.sel(damping_model='CDR')):.2g} %"
    assert f"spread is {words}" in CLAIMS["amp-cdr"]["sensitivity"]


def test_rank_over_the_two_a1_of_the_paper(data):
    xi = ratios(data["match/cracked_stiffness"]).sel({A1: [0.02, 0.04]})
    spreads = mean_spread(xi, A1)
    assert bool(is_largest(spreads, "CDC"))
    assert bool(is_smallest(spreads, "CDR"))
    for study, dim in (("slenderness", "slenderness"), ("overburden", "overburden_ratio")):
        other_spread = mean_spread(
            ratios(data[f"match/{study}"], "damping_ratio_fixed_seconds"), dim
        )
        assert bool((spreads > other_spread).all())


def test_margin_of_cdc_over_the_amplitude(data):
    xi = ratios(data["match/amplitude"]).sel({RELEASE: [0.3, 0.5, 0.9]})
    cdc, _, sdr = mean_spread(xi, RELEASE).values
    assert f"is {cdc / sdr:.2g} times the next" in CLAIMS["amp-cdc"]["sensitivity"]


def test_margins_of_the_rank_over_a1(data):
    cdc, cdr, sdr = mean_spread(ratios(data["match/cracked_stiffness"]), A1).values
    sensitivity = CLAIMS["a1-rank"]["sensitivity"]
    assert f"CDC is {cdc / sdr:.2g} times the next" in sensitivity
    assert f"CDR {cdr / sdr:.2g} of the next" in sensitivity


def test_margin_of_the_errors_below_cdc(data):
    error = matched_error(data)
    cdr, sdr = (error.sel(damping_model=model) for model in ("CDR", "SDR"))
    cdc = error.sel(damping_model="CDC")
    sensitivity = CLAIMS["err-secant"]["sensitivity"]
    assert f"CDR above {float((cdr / cdc).max()):.2g} of CDC's" in sensitivity
    assert f"SDR above {float((sdr / cdc).max()):.2g}" in sensitivity


def test_best_cdr_holds_over_every_a1(data):
    fits = data["equivalence"]["damping_ratio_fit"].sel(damping_model=MODELS)
    assert bool(is_smallest(mean_spread(fits, A1), "CDR"))


def test_fit_order_over_every_a1(data):
    equivalence = data["equivalence"]
    fit = equivalence["damping_ratio_fit"].sel(damping_model="CDR")
    relative = fit / equivalence["giannini_masiani"] - 1
    mean = 100 * float(np.abs(relative).mean())
    share_above = 100 * float((relative > 0).mean())
    sensitivity = CLAIMS["fit-order"]["sensitivity"]
    assert f"differs by {mean:.2g} % on average" in sensitivity
    assert f"at {share_above:.2g} % of all" in sensitivity


def test_low_amplitude_by_other_gaps(data):
    xi = ratios(data["match/amplitude"])
    gap = np.abs(xi.sel(damping_model="SDR") / xi.sel(damping_model="CDR") - 1).mean("restitution")
    at_near, at_reference, at_lowest = gap.sel({RELEASE: [0.3, 0.5, 0.1]}).values
    sdr = xi.sel(damping_model="SDR")
    excess = float((sdr.sel({RELEASE: 0.5}) / sdr.sel({RELEASE: 0.1}) - 1).mean())
    sensitivity = CLAIMS["low-amp"]["sensitivity"]
    assert f"0.3 u_ins is {100 * at_near / at_reference:.2g} %" in sensitivity
    assert f"the gap is {100 * at_lowest:.2g} %" in sensitivity
    assert f"overdamps by {100 * excess:.2g} %" in sensitivity


def test_damping_of_sdr_over_the_next_model(data):
    decrement = data["validation"]["log_decrement"].sel(damping_model=["CR", *MODELS])
    next_model = decrement.drop_sel(damping_model="SDR").max()
    excess = 100 * float(decrement.sel(damping_model="SDR") / next_model - 1)
    assert f"it is {excess:.2g} % larger" in CLAIMS["fig8-sdr"]["sensitivity"]


def models_above_one(ratio):
    return set(ratio["damping_model"].values[ratio.values > 1])


def test_relative_dispersion_over_the_amplitude(data):
    xi = ratios(data["match/amplitude"]).sel({RELEASE: [0.3, 0.5, 0.9]})
    growth = 1 / low_over_high_restitution(spread(xi, RELEASE))
    assert models_above_one(growth) == {"CDR", "SDR"}


def test_relative_dispersion_over_a1(data):
    growth = low_over_high_restitution(spread(ratios(data["match/cracked_stiffness"]), A1))
    assert models_above_one(growth) == {"CDR"}

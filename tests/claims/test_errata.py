"""The errata: the numbers in data/errata.yaml, from the formulas and from the full results."""

import numpy as np
import pytest
import yaml
from pages import read_full
from repository import ROOT
from scipy.optimize import brentq

import rockdamp as rd
from rockdamp.claims.judgement import A1, MODELS, falls, spans
from rockdamp.claims.ratios import ratios
from rockdamp.mechanics.two_bodies import TwoBodies

ERRATA = yaml.safe_load((ROOT / "data/errata.yaml").read_text(encoding="utf-8"))["errata"]
EVIDENCE = {erratum["id"]: erratum["evidence"] for erratum in ERRATA}
FIG5 = {"thickness": 0.3, "height": 4.5}
FIG4 = {"thickness": 0.4, "height": 4.0}


def test_every_erratum_says_where_and_how():
    keys = {"id", "where", "printed", "used", "evidence"}
    assert all(set(erratum) == keys for erratum in ERRATA)
    assert len(EVIDENCE) == len(ERRATA)


def test_printed_bilinear_law_at_rest():
    """In W t/h, for O = W and r = 0.7: F0 = 4/r + 1/(1 - r), printed 4/r + 1/(r (1 - r))."""
    r = 0.7
    f0 = 4 / r + 1 / (1 - r)
    k0 = 4 / r + 2 / (1 - r)
    value = 4 / r + 1 / (r * (1 - r))
    slope = 2 / r + 1 / (r * (1 - r))
    start = f"{value / f0:.3g} F0 at u = 0, the slope -{slope / k0:.3g} K0"
    assert start in EVIDENCE["eq-3"]
    assert f"zero at {value / slope / (f0 / k0):.3g} u_ins" in EVIDENCE["eq-3"]
    wall = rd.Wall(**FIG5, overburden_ratio=1)
    instability = float(wall.rigid_strength / wall.rigid_stiffness)
    assert instability / wall.thickness == pytest.approx(f0 / k0)


@pytest.mark.parametrize("name", ["eq-7", "restitution-of-fig-4"])
def test_eq_7_for_the_wall_of_fig_4(name):
    low, high = (rd.Wall(**FIG4, hinge_ratio=ratio).restitution_rigid for ratio in (0.5, 0.7))
    assert f"(7) gives {low:.3f} for h1/h = 0.5 and {high:.3f} for 0.7" in EVIDENCE[name]
    assert low == pytest.approx(1 - 2 * np.sin(np.arctan(0.2)) ** 2)


def test_impulsive_restitution_of_fig_4():
    low, high = (rd.Wall(**FIG4, hinge_ratio=ratio).restitution_impulsive for ratio in (0.5, 0.7))
    assert f"{low:.3f} and {high:.3f}" in EVIDENCE["eq-7"]
    assert low == pytest.approx((16 - 14 * 0.16) / (16 + 16 * 0.16))


def test_restitution_of_fig_4_needs_a_high_hinge():
    def excess(ratio):
        return rd.Wall(**FIG4, hinge_ratio=ratio).restitution_rigid - 0.955

    hinge_ratio = brentq(excess, 0.5, 0.99)
    assert f"needs h1/h = {hinge_ratio:.3f}" in EVIDENCE["restitution-of-fig-4"]


def test_coordinate_carries_twice_the_energy():
    wall = rd.Wall(**FIG5)
    bodies = TwoBodies(wall)
    assert wall.rigid_strength / bodies.potential_slope(0.0) == pytest.approx(2)
    assert wall.effective_mass / bodies.inertia(float(wall.thickness)) == pytest.approx(2)
    at_rest = float(wall.effective_mass / bodies.inertia(0.0))
    assert f"({at_rest:.2f} times at u = 0)" in EVIDENCE["energy-of-eq-13-and-14"]


def test_force_of_a_hinge_near_the_base():
    low, high = (rd.Wall(**FIG5, hinge_ratio=ratio).rigid_strength for ratio in (0.07, 0.7))
    assert low / high == pytest.approx(10)
    assert "tenfold" in EVIDENCE["hinge-ratio-of-fig-6"]


def test_height_of_the_wall_of_fig_8():
    assert f"{27 * 0.102:.2f} m high" in EVIDENCE["lambda-of-captions"]


@pytest.mark.parametrize(("b1", "words"), [(0.85, "gives a2 = {}"), (0.80, "Fig. 8 gives {}")])
def test_plateau_leaves_no_room_for_the_printed_a1(b1, words):
    plateau_end = rd.TrilinearCurve(0.02, b1).plateau_end
    assert words.format(f"{plateau_end:.3g}") in EVIDENCE["a1-of-section-7"]


# --- the full results --------------------------------------------------------------------------


def test_damping_ratios_by_the_words_of_eq_17():
    match = read_full("match/amplitude")
    squares = match["damping_ratio"].sel(release_amplitude=0.5, method="nearest")
    change = 100 * (match["damping_ratio_absolute"] / squares - 1)
    for model in MODELS:
        values = change.sel(damping_model=model)
        words = f"{float(values.min()):.2g}% to {float(values.max()):.2g}% ({model})"
        assert words in EVIDENCE["eq-17"]


def test_sdr_needs_more_where_the_wall_is_stiffer():
    sdr = ratios(read_full("match/cracked_stiffness")).sel(damping_model="SDR").sortby(A1)
    assert bool(falls(sdr, A1).all())
    assert sdr.sizes["restitution"] == 29
    stiff, soft = sdr.isel({A1: [0, -1]}).mean("restitution").values
    assert f"from {soft:.4f} to {stiff:.4f}" in EVIDENCE["sdr-and-a1"]


def test_no_response_length_bears_both_claims():
    lengths = read_full("response_lengths")
    rises = lengths["error_rises_as_restitution_falls"].sel(damping_model=MODELS).astype(bool)
    all_rise = rises.all("damping_model")
    in_range = lengths["misclassified"] == 0
    by_model = [f"{model} {spans(rises.sel(damping_model=model, drop=True))}" for model in MODELS]
    evidence = EVIDENCE["err-range-and-err-e"]
    assert f"holds for a response length of tau = {spans(in_range)}," in evidence
    assert f"the second for tau = {spans(all_rise)} ({', '.join(by_model)});" in evidence
    assert not bool((in_range & all_rise).any())


def test_cdr_is_never_best_where_sdr_error_rises():
    lengths = read_full("response_lengths")
    rises = lengths["error_rises_as_restitution_falls"].sel(damping_model="SDR").astype(bool)
    best = lengths["error"].sel(damping_model=MODELS).idxmin("damping_model")
    assert not bool(((best == "CDR") & rises).any())
    error = lengths["rms_error"].sel(response_length=8, damping_model="SDR")
    assert float(error.idxmax("restitution")) == pytest.approx(0.8)

"""The errata: the numbers typed in data/errata.yaml, from the formulas and, once built, the full results."""

import numpy as np
import pytest
import yaml
from repository import ROOT
from scipy.optimize import brentq

import rockdamp as rd
from rockdamp.claims.ratios import MODELS, ratios, spans, steady
from rockdamp.mechanics.two_bodies import TwoBodies
from rockdamp.storage import dataset

ERRATA = {
    entry["id"]: entry
    for entry in yaml.safe_load((ROOT / "data/errata.yaml").read_text("utf-8"))["errata"]
}
FIG5 = {"thickness": 0.3, "height": 4.5}


def evidence(name):
    return ERRATA[name]["evidence"]


def built(name):
    path = ROOT / f"results/{name}.nc"
    if not path.exists():
        pytest.skip("the full results are not built")
    return dataset.read(path)


def test_the_printed_bi_linear_law_misses_what_it_should_give_at_rest():
    """Of O = W, r = 0.7, no eccentricity, in W t/h: F0 = 4/r + 1/(1 - r), printed 4/r + 1/(r (1 - r))."""
    r = 0.7
    f0, k0 = 4 / r + 1 / (1 - r), 4 / r + 2 / (1 - r)
    value, slope = 4 / r + 1 / (r * (1 - r)), 2 / r + 1 / (r * (1 - r))
    assert f"{value / f0:.3g} F0 at u = 0, the slope -{slope / k0:.3g} K0" in evidence("eq-3")
    assert f"zero at {value / slope / (f0 / k0):.3g} u_ins" in evidence("eq-3")
    wall = rd.Wall(**FIG5, overburden_ratio=1)
    assert float(wall.rigid_strength / wall.rigid_stiffness / wall.thickness) == pytest.approx(
        f0 / k0
    )


def test_both_restitutions_of_the_wall_of_fig_4():
    walls = [rd.Wall(0.4, 4.0, hinge_ratio=ratio) for ratio in (0.5, 0.7)]
    printed = [f"{wall.restitution_rigid:.3f}" for wall in walls]
    impulsive = [f"{wall.restitution_impulsive:.3f}" for wall in walls]
    assert printed[0] == f"{1 - 2 * np.sin(np.arctan(0.2)) ** 2:.3f}"
    assert impulsive[0] == f"{(16 - 14 * 0.16) / (16 + 16 * 0.16):.3f}"
    for name in ("eq-7", "restitution-of-fig-4"):
        assert f"(7) gives {printed[0]} for h1/h = 0.5 and {printed[1]} for 0.7" in evidence(name)
    assert f"{impulsive[0]} and {impulsive[1]}" in evidence("eq-7")
    needed = brentq(
        lambda ratio: rd.Wall(0.4, 4.0, hinge_ratio=ratio).restitution_rigid - 0.955, 0.5, 0.99
    )
    assert f"needs h1/h = {needed:.3f}" in evidence("restitution-of-fig-4")


def test_the_coordinate_carries_twice_the_mechanical_energy():
    wall = rd.Wall(**FIG5)
    bodies = TwoBodies(wall)
    assert wall.rigid_strength / bodies.potential_slope(0.0) == pytest.approx(2)
    assert wall.effective_mass / bodies.inertia(float(wall.thickness)) == pytest.approx(2)
    assert f"({wall.effective_mass / bodies.inertia(0.0):.2f} times at u = 0)" in evidence(
        "energy-of-eq-13-and-14"
    )


def test_hinge_slenderness_and_plateau_of_the_misprints():
    low, high = (rd.Wall(**FIG5, hinge_ratio=ratio).rigid_strength for ratio in (0.07, 0.7))
    assert low / high == pytest.approx(10) and "tenfold" in evidence("hinge-ratio-of-fig-6")
    assert f"{27 * 0.102:.2f} m high" in evidence("lambda-of-captions")
    ends = [f"{rd.TrilinearCurve(0.02, b1).plateau_end:.3g}" for b1 in (0.85, 0.80)]
    assert f"a2 = {ends[0]}" in evidence("a1-of-section-7") and f"gives {ends[1]}" in evidence(
        "a1-of-section-7"
    )


def test_damping_ratios_by_the_words_of_eq_17():
    match = built("match/amplitude")
    squares = match["damping_ratio"].sel(release_amplitude=0.5, method="nearest")
    change = 100 * (match["damping_ratio_absolute"] / squares - 1).sel(damping_model=MODELS)
    for model, values in zip(MODELS, change, strict=True):
        assert f"{float(values.min()):.2g}% to {float(values.max()):.2g}% ({model})" in evidence(
            "eq-17"
        )


def test_sdr_rises_where_the_wall_is_stiffer():
    sdr = (
        ratios(built("match/cracked_stiffness"))
        .sel(damping_model="SDR")
        .sortby("yield_displacement_ratio")
    )
    assert (
        bool(steady(sdr, "yield_displacement_ratio", -1).all()) and sdr.sizes["restitution"] == 29
    )
    low, high = sdr.isel(yield_displacement_ratio=[0, -1]).mean("restitution").values
    assert f"from {high:.4f} to {low:.4f}" in evidence("sdr-and-a1")


def test_no_length_of_the_response_bears_both_sentences_on_the_error():
    lengths = built("response_lengths")
    rises = lengths["error_rises_as_restitution_falls"].sel(damping_model=MODELS).astype(bool)
    every = rises.all("damping_model")
    in_range = lengths["misclassified"] == 0
    cdc, cdr, sdr = (spans(rises.sel(damping_model=model, drop=True)) for model in MODELS)
    words = f"at {spans(in_range)} in tau, the second at {spans(every)} (CDC {cdc}, CDR {cdr}, SDR {sdr})"
    assert words in evidence("err-range-and-err-e")
    assert not bool((in_range & every).any())
    best = lengths["error"].sel(damping_model=MODELS).idxmin("damping_model")
    assert not bool((best == "CDR").where(rises.sel(damping_model="SDR", drop=True), False).any())
    error = lengths["rms_error"].sel(response_length=8, damping_model="SDR")
    assert float(error.idxmax("restitution")) == pytest.approx(0.8)

"""The comparison of dampers with restitution: made-up histories whose statistics are known or can be counted."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.config import Bootstrap
from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.statistics.fragility import resample
from rockdamp.statistics.paired import compare_pairs
from rockdamp.storage import dataset
from rockdamp.studies.comparison import compare_dampers
from rockdamp.studies.earthquakes import SOURCES

VARIATIONS = ["step", "impact", "lower e", "higher e"]

DIMS = ("record", "velocity_ratio", "wall", "restitution", "damping_model", "damping_ratio_source")


def configure(replicates=50, seed=4, bands=(0.01, 0.1, 0.5, 1.0)):
    config = configured({"comparison": {"bands": list(bands)}})
    bootstrap = Bootstrap.model_construct(
        replicates=replicates, seed=seed
    )  # of one replicate too, which no file may
    return changed(config, {"comparison.bootstrap": bootstrap})


def histories(peak, station, velocity_ratio, varied=None, collapsed=None, **coords):
    """Peaks of two walls at two e under every damper; unless `collapsed` says so, they collapse beyond 1."""
    collapsed = (peak > 1).astype(np.int8) if collapsed is None else collapsed
    varied = peak[..., :1, 0] * np.ones(len(VARIATIONS)) if varied is None else varied
    ratio = np.full(peak.shape[2:], 0.05)
    ratio[:, :, 0] = np.nan
    names = {"wall": ["a", "b"], "restitution": [0.8, 0.9], "variation": VARIATIONS}
    names |= {"damping_model": list(MODELS), "damping_ratio_source": list(SOURCES)}
    return xr.Dataset(
        {
            "peak": (DIMS, peak),
            "peak_uncertainty": (DIMS, 1e-3 * peak),
            "collapsed": (DIMS, collapsed),
            "converged": (DIMS, np.ones_like(collapsed)),
            "varied_peak": ((*DIMS[:4], "variation"), varied),
            "varied_collapsed": ((*DIMS[:4], "variation"), (varied > 1).astype(np.int8)),
            "damping_ratio": (DIMS[2:], ratio),
        },
        coords={
            "record": [f"r{i}" for i in range(len(station))],
            "station": ("record", station),
            "velocity_ratio": velocity_ratio,
            **names,
            **coords,
        },
    )


def proportional(ratio):
    """Of 40 records; the dampers' peaks are those of CR times `ratio`."""
    scale, capacity = (
        np.geomspace(0.2, 5.0, 12),
        np.random.default_rng(5).lognormal(0.0, 0.4, (40, 1, 2, 2)),
    )
    cr = 0.6 * scale[:, None, None] / capacity
    factor = np.array([1.0] + [ratio] * len(VISCOUS_MODELS))
    return histories(
        cr[..., None, None] * factor[:, None] * np.ones(3), [f"s{i // 2}" for i in range(40)], scale
    )


STATION = [
    f"s{station}" for station in range(12) for _ in range(1 + station % 3)
]  # of one, two and three components


def scattered():
    """Peaks that differ from CR's at random, the less the earlier the damper stands."""
    rng, scale = np.random.default_rng(2), np.geomspace(0.2, 5.0, 9)
    shape = (len(STATION), scale.size, 2, 2)
    cr = 0.6 * scale[:, None, None] / rng.lognormal(0.0, 0.4, (len(STATION), 1, 2, 2))
    scatter = np.arange(len(MODELS))[:, None] * 0.10 * np.array([1.0, 1.1, 1.2])
    common = rng.normal(size=(len(STATION), 1, 1, 1, 1, 1))
    peaks = cr[..., None, None] * np.exp(
        scatter * (0.3 * common + rng.normal(size=(*shape, len(MODELS), 3)))
    )
    varied = cr[..., None] * np.exp(0.05 * rng.normal(size=(*shape, len(VARIATIONS))))
    return histories(peaks, STATION, scale, varied)


def test_peaks_in_proportion_move_the_fragility():
    found = compare_dampers(configure(), proportional(0.9))
    dataset.check(found, "comparison")
    dampers = found.sel(damping_model=list(VISCOUS_MODELS))
    np.testing.assert_allclose(dampers["median_ratio"].isel(band=0), 0.9, rtol=1e-12)
    np.testing.assert_allclose(dampers["median_ratio_interval"].isel(band=0), 0.9, rtol=1e-12)
    np.testing.assert_allclose(dampers["log_error"].isel(band=0), -np.log(0.9), rtol=1e-9)
    # The scales are stripes, so the median moves by the ratio only as far as the fit sees between them.
    np.testing.assert_allclose(dampers["median_intensity_ratio"], 1 / 0.9, rtol=0.03)
    low, high = dampers["median_intensity_ratio_interval"].transpose("bound", ...)
    assert (low <= dampers["median_intensity_ratio"]).all() and (
        dampers["median_intensity_ratio"] <= high
    ).all()
    assert (dampers["added_collapse_rate"] == 0).all() and (
        dampers["missed_collapse_rate"] > 0
    ).all()


def test_source_is_compared_on_walls_with_its_ratio():
    """The polynomials have none for wall b: their statistics are those of a study without it, the others' not."""
    study = scattered()
    missing = (study["wall"] == "b") & (study["damping_ratio_source"] == "polynomial")
    missing = missing & (study["damping_model"] != "CR")
    study["damping_ratio"] = study["damping_ratio"].where(~missing)
    study["collapsed"] = study["collapsed"].where(~missing, -1).transpose(*DIMS)
    both, one = (compare_dampers(configure(), each) for each in (study, study.sel(wall=["a"])))
    assert both["pooled"].sel(damping_ratio_source="polynomial").values.tolist() == [1, 0]
    assert both["pooled"].drop_sel(damping_ratio_source="polynomial").values.all()
    at = {"damping_model": list(VISCOUS_MODELS), "damping_ratio_source": "polynomial"}
    for name in (
        "log_error",
        "pairs",
        "missed_collapse_rate",
        "added_collapse_rate",
        "median_intensity_ratio_interval",
    ):
        np.testing.assert_array_equal(both[name].sel(at), one[name].sel(at))
    at["damping_ratio_source"] = "closed form"
    assert (both["pairs"].isel(band=0).sel(at) > one["pairs"].isel(band=0).sel(at)).all()


def test_rates_of_a_source_count_the_histories_that_it_ran():
    """CR collapses both walls under the first record; the first wall has no ratio, which is no missed collapse."""
    fell = np.zeros((2, 1, 2), dtype=np.int8)
    fell[0] = 1
    other = np.zeros_like(fell)
    other[:, :, 0] = -1
    reference = np.where(fell, 1.5, 0.5)
    stored = {
        "reference_peak": reference,
        "reference_collapsed": fell,
        "peak": 1.1 * reference,
        "collapsed": other,
    }
    made = xr.Dataset({name: (DIMS[:3], values) for name, values in stored.items()})
    found = compare_pairs(made, np.ones((3, 2)), [(0.0, np.inf)])
    assert (found["missed_collapse_rate"], found["added_collapse_rate"], found["pairs"]) == (
        1.0,
        0.0,
        1,
    )


# --- counted by hand -------------------------------------------------------------------------------------------------


def compare_few(peak, collapsed=None, scale=(1.0,)):
    """Compare CDR with CR on one wall; `peak` and `collapsed` have the shape (records, scales, 2)."""
    peaks = np.asarray(peak, dtype=float)[:, :, None, None, :, None]
    ended = np.zeros(peaks.shape, dtype=np.int8)
    if collapsed is not None:
        ended[...] = np.asarray(collapsed)[:, :, None, None, :, None]
    names = {"wall": ["one"], "restitution": [0.85], "damping_model": ["CR", "CDR"]}
    names |= {"damping_ratio_source": ["least error"], "variation": ["step"]}
    stations = [f"s{i}" for i in range(len(peaks))]
    made = histories(peaks, stations, list(scale), peaks[..., 0, :], ended, **names)
    found = compare_dampers(configure(60, bands=(0.1, 0.2, 0.4)), made)
    return made, found.squeeze(["wall", "restitution", "damping_ratio_source"]).sel(
        damping_model="CDR"
    )


def test_rates_are_of_collapses_and_of_survivals():
    """CR collapses in four of ten histories. The damper survives one of the four, and collapses in two of the six."""
    cr, damper = [1, 1, 1, 1, 0, 0, 0, 0, 0, 0], [1, 1, 1, 0, 1, 1, 0, 0, 0, 0]
    _, found = compare_few(np.full((10, 1, 2), 0.15), np.stack([cr, damper], axis=-1)[:, None])
    assert (
        float(found["missed_collapse_rate"]) == 1 / 4
        and float(found["added_collapse_rate"]) == 2 / 6
    )
    assert int(found["pairs"].isel(band=0)) == 4


def test_peak_at_an_edge_is_in_the_band_above():
    cr = np.array([0.0999, 0.1, 0.2, 0.3, 0.4])
    _, found = compare_few(np.stack([cr, cr * [7, 2, 3, 3, 7]], axis=-1)[:, None])
    assert found["band_start"].values.tolist() == [0.1, 0.1, 0.2] and found[
        "band_end"
    ].values.tolist() == [
        0.4,
        0.2,
        0.4,
    ]
    assert found["pairs"].values.tolist() == [3, 1, 2]
    np.testing.assert_allclose(found["median_ratio"], [3, 2, 3])
    np.testing.assert_allclose(
        found["log_error"], np.sqrt([np.mean(np.log([2, 3, 3]) ** 2), *np.log([2, 3]) ** 2])
    )


def test_equal_collapses_have_a_ratio_of_one():
    """However uncertain each of both medians is, they are resampled together."""
    scale, capacity = np.geomspace(0.2, 5.0, 8), np.random.default_rng(9).lognormal(0.0, 0.4, 20)
    fell = np.repeat((capacity[:, None] <= scale)[..., None], 2, axis=-1)
    _, found = compare_few(np.full(fell.shape, 0.15), fell, scale)
    assert np.ptp(found["median_velocity_ratio_interval"].values) > 0.1
    np.testing.assert_allclose(found["median_intensity_ratio_interval"], [1, 1])


def test_history_of_cr_counts_once():
    """CR, which no step settles, and CDR with two ratios: two of three histories are converged."""
    one, _ = compare_few(np.full((4, 1, 2), 0.15))
    other = one.assign_coords(damping_ratio_source=["closed form"])
    made = xr.concat(
        [one, other],
        "damping_ratio_source",
        data_vars="minimal",
        coords="minimal",
        compat="override",
    )
    made["converged"] = xr.ones_like(made["collapsed"]).where(made["damping_model"] != "CR", 0)
    assert float(compare_dampers(configure(), made)["converged_share"]) == pytest.approx(2 / 3)


# --- the bootstrap over stations -------------------------------------------------------------------------------------


def test_replicate_is_the_study_of_its_records():
    """Of one replicate both ends of an interval are the replicate itself; here every record drawn is written out."""
    study, times = scattered(), resample(STATION, 1, 4)[0].astype(int)
    assert times.sum() != len(STATION) and times.max() > 1
    drawn = study.isel(record=np.repeat(np.arange(len(STATION)), times))
    found, again = (compare_dampers(configure(1), data) for data in (study, drawn))
    judged = 0
    for key in (key for key in found if str(key).endswith("_interval")):
        statistic = again[str(key).removesuffix("_interval")]
        for bound in ("lower", "upper"):
            replicate = found[key].sel(bound=bound).transpose(*statistic.dims)
            np.testing.assert_allclose(
                replicate, statistic, rtol=1e-9, atol=1e-12, err_msg=str(key)
            )
        whole = found[statistic.name].values
        judged += int(
            np.isfinite(whole).any() and not np.array_equal(whole, statistic.values, equal_nan=True)
        )
    assert judged >= 3


def test_excess_is_over_histories_that_survive_with_both():
    study = scattered()
    found = compare_dampers(configure(1), study)["excess"]
    for e in (0.8, 0.9):
        at = study.sel(restitution=e)
        cr = at.sel(damping_model="CR").isel(damping_ratio_source=0)
        least = at.sel(damping_model=MODELS[1], damping_ratio_source="polynomial")
        other = at.sel(damping_model=MODELS[3], damping_ratio_source="least error")
        both = (cr["collapsed"] + least["collapsed"] + other["collapsed"] == 0) & (
            cr["peak"] >= 0.01
        )
        errors = [
            float(np.sqrt((np.log(one["peak"] / cr["peak"]) ** 2).where(both).mean()))
            for one in (least, other)
        ]
        excess = found.sel(
            restitution=e, damping_model=MODELS[3], damping_ratio_source="least error"
        )
        assert float(excess) == pytest.approx(errors[1] - errors[0], rel=1e-12)
        assert (
            float(
                found.sel(restitution=e, damping_model=MODELS[1], damping_ratio_source="polynomial")
            )
            == 0.0
        )


def test_larger_error_in_every_history_is_certain():
    """The second damper errs a tenth more than the first."""
    study = scattered()
    cr, first = study["peak"].sel(damping_model="CR"), study["peak"].isel(damping_model=2)
    peaks = xr.where(study["damping_model"] == MODELS[1], first, study["peak"])
    peaks = xr.where(
        study["damping_model"] == MODELS[2], cr * (first / cr) ** 1.1, peaks
    ).transpose(*DIMS)
    study = study.assign(peak=peaks, collapsed=(peaks > 1).astype(np.int8))
    found = compare_dampers(configure(200), study).sel(
        damping_ratio_source="polynomial", restitution=0.8
    )
    one, other = (
        found["log_error_interval"].isel(band=0).sel(damping_model=model) for model in MODELS[1:3]
    )
    assert float(one.sel(bound="upper")) > float(other.sel(bound="lower"))
    assert float(found["excess_interval"].sel(damping_model=MODELS[2], bound="lower")) > 0

"""The comparison of dampers with restitution: made histories with known statistics."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured

from rockdamp.config import Bootstrap
from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.statistics.fragility import resample
from rockdamp.storage import dataset
from rockdamp.studies.comparison import compare_dampers
from rockdamp.studies.earthquakes import SOURCES

VARIATIONS = ["step", "impact", "lower e", "higher e"]
DIMS = ("record", "velocity_ratio", "wall", "restitution", "damping_model", "damping_ratio_source")
STATION = [f"s{k}" for k in range(12) for _ in range(1 + k % 3)]  # one to three components


def configure(replicates=50, seed=4, bands=(0.01, 0.1, 0.5, 1.0)):
    config = configured({"comparison": {"bands": list(bands)}})
    # A file may not ask for one replicate; a model built without checks may.
    bootstrap = Bootstrap.model_construct(replicates=replicates, seed=seed)
    return changed(config, {"comparison.bootstrap": bootstrap})


def make_histories(peak, station, velocity_ratio, varied_peak=None, **coords):
    """Return histories of two walls at two e; a peak over 1 is a collapse."""
    collapsed = (peak > 1).astype(np.int8)
    if varied_peak is None:
        varied_peak = peak[..., :1, 0] * np.ones(len(VARIATIONS))
    damping_ratio = np.full(peak.shape[2:], 0.05)
    damping_ratio[:, :, 0] = np.nan
    names = {
        "record": [f"r{index}" for index in range(len(station))],
        "station": ("record", station),
        "velocity_ratio": velocity_ratio,
        "wall": ["a", "b"],
        "restitution": [0.8, 0.9],
        "damping_model": list(MODELS),
        "damping_ratio_source": list(SOURCES),
        "variation": VARIATIONS,
    }
    values = {
        "peak": (DIMS, peak),
        "peak_uncertainty": (DIMS, 1e-3 * peak),
        "collapsed": (DIMS, collapsed),
        "converged": (DIMS, np.ones_like(collapsed)),
        "varied_peak": ((*DIMS[:4], "variation"), varied_peak),
        "varied_collapsed": ((*DIMS[:4], "variation"), (varied_peak > 1).astype(np.int8)),
        "damping_ratio": (DIMS[2:], damping_ratio),
    }
    return xr.Dataset(values, coords=names | coords)


def make_proportional(ratio):
    """Return 40 records under which every damper's peaks are those of CR times `ratio`."""
    levels = np.geomspace(0.2, 5.0, 12)
    capacity = np.random.default_rng(5).lognormal(0.0, 0.4, (40, 1, 2, 2))
    cr = 0.6 * levels[:, None, None] / capacity
    factor = np.full(len(MODELS), ratio)
    factor[0] = 1.0
    peak = cr[..., None, None] * factor[:, None] * np.ones(len(SOURCES))
    stations = [f"s{index // 2}" for index in range(40)]
    return make_histories(peak, stations, levels)


@pytest.fixture(scope="module")
def proportional():
    return compare_dampers(configure(), make_proportional(0.9))


@pytest.fixture
def scattered():
    """Peaks that differ from CR's at random, the less the earlier the damper stands."""
    rng = np.random.default_rng(2)
    levels = np.geomspace(0.2, 5.0, 9)
    shape = (len(STATION), levels.size, 2, 2)
    capacity = rng.lognormal(0.0, 0.4, (len(STATION), 1, 2, 2))
    cr = 0.6 * levels[:, None, None] / capacity
    scatter = np.arange(len(MODELS))[:, None] * 0.10 * np.array([1.0, 1.1, 1.2])
    common = rng.normal(size=(len(STATION), 1, 1, 1, 1, 1))
    difference = 0.3 * common + rng.normal(size=(*shape, len(MODELS), len(SOURCES)))
    peak = cr[..., None, None] * np.exp(scatter * difference)
    difference = rng.normal(size=(*shape, len(VARIATIONS)))
    varied_peak = cr[..., None] * np.exp(0.05 * difference)
    return make_histories(peak, STATION, levels, varied_peak)


def test_peaks_in_proportion_have_their_ratio(proportional):
    dataset.check(proportional, "comparison")
    dampers = proportional.sel(damping_model=list(VISCOUS_MODELS)).isel(band=0)
    np.testing.assert_allclose(dampers["median_ratio"], 0.9, rtol=1e-12)
    np.testing.assert_allclose(dampers["median_ratio_interval"], 0.9, rtol=1e-12)
    np.testing.assert_allclose(dampers["log_error"], -np.log(0.9), rtol=1e-9)


def test_peaks_in_proportion_move_the_fragility(proportional):
    dampers = proportional.sel(damping_model=list(VISCOUS_MODELS))
    ratio = dampers["median_intensity_ratio"]
    # The levels are stripes: the fit sees the median move between them only roughly.
    np.testing.assert_allclose(ratio, 1 / 0.9, rtol=0.03)
    low, high = dampers["median_intensity_ratio_interval"].transpose("bound", ...)
    assert (low <= ratio).all()
    assert (ratio <= high).all()
    assert (dampers["added_collapse_rate"] == 0).all()
    assert (dampers["missed_collapse_rate"] > 0).all()


def test_source_is_compared_on_walls_with_its_ratio(scattered):
    """The polynomials have no ratio for wall b: they are compared on wall a, the others on both."""
    missing = (scattered["wall"] == "b") & (scattered["damping_ratio_source"] == "polynomial")
    missing = missing & (scattered["damping_model"] != "CR")
    scattered["damping_ratio"] = scattered["damping_ratio"].where(~missing)
    scattered["collapsed"] = scattered["collapsed"].where(~missing, -1).transpose(*DIMS)
    both_walls = compare_dampers(configure(), scattered)
    first_wall = compare_dampers(configure(), scattered.sel(wall=["a"]))
    walls = both_walls["pooled"]
    assert walls.sel(damping_ratio_source="polynomial").values.tolist() == [1, 0]
    assert walls.drop_sel(damping_ratio_source="polynomial").values.all()
    dampers = {"damping_model": list(VISCOUS_MODELS)}
    polynomial = dampers | {"damping_ratio_source": "polynomial"}
    rates = ["missed_collapse_rate", "added_collapse_rate"]
    for name in ["log_error", "pairs", *rates, "median_intensity_ratio_interval"]:
        expected = first_wall[name].sel(polynomial)
        np.testing.assert_array_equal(both_walls[name].sel(polynomial), expected)
    closed_form = dampers | {"damping_ratio_source": "closed form"}
    pairs = both_walls["pairs"].isel(band=0).sel(closed_form)
    first_pairs = first_wall["pairs"].isel(band=0).sel(closed_form)
    assert (pairs > first_pairs).all()


# --- counted by hand --------------------------------------------------------------------------


def make_two_models(peak):
    """Return one wall under CR and CDR; `peak` has the shape (records, 2)."""
    peaks = peak[:, None, None, None, :, None]
    coords = {
        "wall": ["loaded"],
        "restitution": [0.85],
        "damping_model": ["CR", "CDR"],
        "damping_ratio_source": ["least error"],
        "variation": ["step"],
    }
    stations = [f"s{index}" for index in range(len(peaks))]
    return make_histories(peaks, stations, [1.0], peaks[..., 0, :], **coords)


def compare_cdr(peak):
    """Return the statistics of CDR, whose histories are those of `make_two_models`."""
    histories = make_two_models(peak)
    compared = compare_dampers(configure(60, bands=(0.1, 0.2, 0.4)), histories)
    squeezed = compared.squeeze(["wall", "restitution", "damping_ratio_source"])
    return squeezed.sel(damping_model="CDR")


def test_peak_at_an_edge_is_in_the_band_above():
    cr = np.array([0.0999, 0.1, 0.2, 0.3, 0.4])
    cdr = cr * [7, 2, 3, 3, 7]
    statistics = compare_cdr(np.stack([cr, cdr], axis=-1))
    assert statistics["band_start"].values.tolist() == [0.1, 0.1, 0.2]
    assert statistics["band_end"].values.tolist() == [0.4, 0.2, 0.4]
    assert statistics["pairs"].values.tolist() == [3, 1, 2]
    np.testing.assert_allclose(statistics["median_ratio"], [3, 2, 3])
    mean_square = np.mean(np.log([2, 3, 3]) ** 2)
    log_error = [np.sqrt(mean_square), np.log(2), np.log(3)]
    np.testing.assert_allclose(statistics["log_error"], log_error)


def test_history_of_cr_counts_once():
    """CR, which no step settles, and CDR with two ratios: two of three histories are converged."""
    source = make_two_models(np.full((4, 2), 0.15))
    second_source = source.assign_coords(damping_ratio_source=["closed form"])
    options = {"data_vars": "minimal", "coords": "minimal", "compat": "override"}
    histories = xr.concat([source, second_source], "damping_ratio_source", **options)
    converged = xr.ones_like(histories["collapsed"])
    histories["converged"] = converged.where(histories["damping_model"] != "CR", 0)
    share = compare_dampers(configure(), histories)["converged_share"]
    assert float(share) == pytest.approx(2 / 3)


# --- the bootstrap over stations --------------------------------------------------------------


def test_replicate_is_the_study_of_its_records(scattered):
    """Both ends of an interval are the only replicate; here its records are repeated."""
    times = resample(STATION, 1, 4)[0].astype(int)
    assert times.sum() != len(STATION)
    assert times.max() > 1
    repeated = scattered.isel(record=np.repeat(np.arange(len(STATION)), times))
    statistics = compare_dampers(configure(1), scattered)
    repeated_statistics = compare_dampers(configure(1), repeated)
    names = [
        str(name).removesuffix("_interval")
        for name in statistics
        if str(name).endswith("_interval")
    ]
    differing = 0
    for name in names:
        expected = repeated_statistics[name]
        interval = statistics[f"{name}_interval"].transpose("bound", *expected.dims)
        for replicate in interval:
            np.testing.assert_allclose(replicate, expected, rtol=1e-9, atol=1e-12, err_msg=name)
        original = statistics[name].values
        same = np.array_equal(original, expected.values, equal_nan=True)
        differing += np.isfinite(original).any() and not same
    assert differing >= 3


@pytest.mark.parametrize("e", [0.8, 0.9])
def test_excess_is_over_histories_that_survive_with_both(scattered, e):
    best_case = {"damping_model": MODELS[1], "damping_ratio_source": "polynomial"}
    worse_case = {"damping_model": MODELS[3], "damping_ratio_source": "least error"}
    histories = scattered.sel(restitution=e)
    cr = histories.sel(damping_model="CR").isel(damping_ratio_source=0)
    best = histories.sel(best_case)
    worse = histories.sel(worse_case)
    survived = cr["collapsed"] + best["collapsed"] + worse["collapsed"] == 0
    compared = survived & (cr["peak"] >= 0.01)

    def log_error(model):
        squares = np.log(model["peak"] / cr["peak"]) ** 2
        return float(np.sqrt(squares.where(compared).mean()))

    excess = compare_dampers(configure(1), scattered)["excess"].sel(restitution=e)
    expected = log_error(worse) - log_error(best)
    assert float(excess.sel(worse_case)) == pytest.approx(expected, rel=1e-12)
    assert float(excess.sel(best_case)) == 0.0


def test_larger_error_in_every_history_is_certain(scattered):
    """The second damper errs a tenth more than the first."""
    model = scattered["damping_model"]
    cr = scattered["peak"].sel(damping_model="CR")
    first = scattered["peak"].isel(damping_model=2)
    second = cr * (first / cr) ** 1.1
    peaks = xr.where(model == MODELS[1], first, scattered["peak"])
    peaks = xr.where(model == MODELS[2], second, peaks).transpose(*DIMS)
    histories = scattered.assign(peak=peaks, collapsed=(peaks > 1).astype(np.int8))
    compared = compare_dampers(configure(200), histories)
    statistics = compared.sel(damping_ratio_source="polynomial", restitution=0.8)
    interval = statistics["log_error_interval"].isel(band=0)
    upper = float(interval.sel(damping_model=MODELS[1], bound="upper"))
    lower = float(interval.sel(damping_model=MODELS[2], bound="lower"))
    assert upper > lower
    excess = statistics["excess_interval"].sel(damping_model=MODELS[2], bound="lower")
    assert float(excess) > 0

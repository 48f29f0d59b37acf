"""The bootstrap over stations: each replicate is the study of the records that it draws, written out."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured
from made_up_earthquakes import MODELS, histories

from rockdamp.config import Bootstrap
from rockdamp.statistics.fragility import resample
from rockdamp.studies import comparison

STATION = [f"s{station}" for station in range(12) for _ in range(1 + station % 3)]  # of one, two and three components
SCALE = np.geomspace(0.2, 5.0, 9)
BANDS = [0.01, 0.1, 0.5, 1.0]


def config(replicates=1, seed=4):
    bootstrap = {"replicates": replicates, "seed": seed}
    config = configured({"comparison": {"bands": BANDS}})
    made = Bootstrap.model_construct(**bootstrap)  # of a single replicate, which no file may ask for
    return changed(config, {"comparison.bootstrap": made})


def records():
    return {"record": [f"r{i}" for i in range(len(STATION))], "station": ("record", STATION)}


def drawn(data, seed=4):
    """The records that the first replicate draws, written out one after the other."""
    times = resample(STATION, 1, seed)[0].astype(int)
    assert times.sum() != len(STATION) and times.max() > 1
    return data.isel(record=np.repeat(np.arange(len(STATION)), times))


def study():
    """Peaks that differ from CR's at random, the less the earlier the damper stands; beyond 1 they collapse."""
    rng = np.random.default_rng(2)
    shape = (len(STATION), SCALE.size, 2, 2)
    cr = 0.6 * SCALE[:, None, None] / rng.lognormal(0.0, 0.4, (len(STATION), 1, 2, 2))
    scatter = np.arange(len(MODELS))[:, None] * 0.10 * np.array([1.0, 1.1, 1.2])
    of_station = rng.normal(size=(len(STATION), 1, 1, 1, 1, 1))
    peaks = cr[..., None, None] * np.exp(scatter * (0.3 * of_station + rng.normal(size=(*shape, len(MODELS), 3))))
    varied = cr[..., None] * np.exp(0.05 * rng.normal(size=(*shape, 4)))
    return histories(peaks, varied, STATION, SCALE)


def test_each_replicate_is_the_study_of_the_records_that_it_draws():
    """Of one replicate both ends of an interval are the replicate itself; here every record drawn is written out."""
    found, again = (comparison.compare_dampers(config(), data) for data in (study(), drawn(study())))
    judged = 0
    for key in (key for key in found if str(key).endswith("_interval")):
        statistic = again[str(key).removesuffix("_interval")]
        for bound in ("lower", "upper"):
            replicate = found[key].sel(bound=bound).transpose(*statistic.dims)
            np.testing.assert_allclose(replicate, statistic, rtol=1e-9, atol=1e-12, err_msg=str(key))
        whole = found[statistic.name].values
        judged += int(np.isfinite(whole).any() and not np.array_equal(whole, statistic.values, equal_nan=True))
    assert judged >= 3


def test_the_excess_is_the_difference_of_errors_over_the_histories_that_stand_with_both():
    given = study()
    found = comparison.compare_dampers(config(), given)["excess"]
    peak, fell = given["peak"], given["collapsed"]
    for e in (0.8, 0.9):
        cr, cr_fell = (values.sel(restitution=e, damping_model="CR") for values in (peak, fell))
        cr, cr_fell = cr.isel(damping_ratio_source=0).values, cr_fell.isel(damping_ratio_source=0).values
        least, other = (
            [
                values.sel(restitution=e, damping_model=model, damping_ratio_source=source).values
                for values in (peak, fell)
            ]
            for model, source in ((MODELS[1], "polynomial"), (MODELS[3], "least error"))
        )
        both = (cr_fell + least[1] + other[1] == 0) & (cr >= BANDS[0]) & (cr < BANDS[-1])
        expected = np.subtract(*(np.sqrt(np.mean(np.log(one[0][both] / cr[both]) ** 2)) for one in (other, least)))
        own = found.sel(restitution=e, damping_model=MODELS[3], damping_ratio_source="least error")
        assert float(own) == pytest.approx(expected, rel=1e-12)
        assert float(found.sel(restitution=e, damping_model=MODELS[1], damping_ratio_source="polynomial")) == 0.0
    assert found.sel(damping_model="CR").isnull().all()


def test_dampers_that_share_their_scatter_are_told_apart_though_their_intervals_overlap():
    """The second damper errs a tenth more than the first in every history: certain, however much both scatter."""
    given = study()
    cr = given["peak"].sel(damping_model="CR")
    first = given["peak"].isel(damping_model=2)
    more = cr * (first / cr) ** 1.1
    peaks = xr.where(given["damping_model"] == MODELS[1], first, given["peak"])
    peaks = xr.where(given["damping_model"] == MODELS[2], more, peaks).transpose(*given["peak"].dims)
    given = given.assign(peak=peaks, collapsed=(peaks > 1).astype(np.int8))
    at = comparison.compare_dampers(config(replicates=200), given).sel(
        damping_ratio_source="polynomial", restitution=0.8
    )
    one, other = (at["log_error_interval"].isel(band=0).sel(damping_model=model) for model in MODELS[1:3])
    assert float(one.sel(bound="upper")) > float(other.sel(bound="lower"))
    assert float(at["excess_interval"].sel(damping_model=MODELS[2], bound="lower")) > 0

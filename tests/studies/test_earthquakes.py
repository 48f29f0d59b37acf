"""Walls under earthquakes: what is run, the bound of its error, and what is made of it."""

import numpy as np
import pytest
import xarray as xr
from configs import changed, configured
from made_up_earthquakes import histories

from rockdamp.config import GeometricGrid
from rockdamp.constants import MODELS, VISCOUS_MODELS
from rockdamp.equivalence.equivalent import equivalent
from rockdamp.equivalence.polynomials import shipped_polynomials
from rockdamp.motions import catalogue
from rockdamp.motions.intensity import intensity_measures
from rockdamp.statistics.paired import compare_pairs
from rockdamp.storage import dataset
from rockdamp.studies import comparison, earthquakes, event_driven_check

RECORDS = ["fema-p695:far-field/[1-3]/a"]


MADE_UP_FIT = 0.05  # xi at any e of a damper that was added and has no polynomials yet


@pytest.fixture(scope="module")
def config():
    """The study's own, for two jobs of three records."""
    return configured(
        {"records": RECORDS, "earthquakes": {"chunk": 2, "restitution": [0.80, 0.85]}},
        {"comparison": {"bootstrap": {"replicates": 50, "seed": 1}}},
    )


@pytest.fixture(scope="module")
def equivalence():
    """The polynomials that the package ships, as the pipeline's dataset has them; constants of a damper without any."""
    fits = shipped_polynomials()
    a1 = np.asarray(fits.yield_displacement_ratio)
    return xr.Dataset(
        {
            "coefficient": (
                ("damping_model", "yield_displacement_ratio", "degree"),
                [
                    fits.coefficient.get(model, np.tile([MADE_UP_FIT, 0.0, 0.0], (a1.size, 1)))
                    for model in VISCOUS_MODELS
                ],
            )
        },
        coords={
            "damping_model": list(VISCOUS_MODELS),
            "yield_displacement_ratio": a1,
            "degree": np.arange(3),
            "restitution": list(fits.restitution),
        },
    )


@pytest.fixture(scope="module")
def walls(config, equivalence):
    return earthquakes.walls(config, equivalence)


@pytest.fixture(scope="module")
def study(config, walls):
    return earthquakes.gather(config, walls, [earthquakes.chunk(share, config, walls) for share in "01"])


@pytest.fixture(scope="module")
def compared(config, study):
    return comparison.compare_dampers(config, study)


# --- the walls -------------------------------------------------------------------------------------------------------


def test_each_source_of_the_damping_ratio_is_what_its_name_says(config, walls):
    for named in config.earthquakes.walls:
        curve = named.curve
        rows = equivalent(0.85, curve)
        of_wall = walls["damping_ratio"].sel(wall=named.name, restitution=0.85)
        for row in rows:
            own = of_wall.sel(damping_model=row["damping_model"])
            assert own.sel(damping_ratio_source="least error") == pytest.approx(row["damping_ratio"], rel=1e-12)
            assert own.sel(damping_ratio_source="closed form") == pytest.approx(row["damping_ratio_energy"], rel=1e-12)
            expected = row["damping_ratio_fit"]
            fit = own.sel(damping_ratio_source="polynomial")
            if expected is None:
                assert np.isnan(fit)
            else:
                assert fit == pytest.approx(expected, rel=1e-12)
        assert np.isnan(of_wall.sel(damping_model="CR")).all()


# --- the histories ---------------------------------------------------------------------------------------------------


def test_the_study_has_the_dimensions_that_others_depend_on(study):
    dataset.check(study, "earthquakes")
    dims = ("record", "velocity_ratio", "wall", "restitution", "damping_model", "damping_ratio_source")
    assert study["peak"].dims == study["collapsed"].dims == dims
    assert study["record"].values.tolist() == [f"far-field/{number}/a" for number in (1, 2, 3)]
    assert study.sizes["velocity_ratio"] >= 12 and study["damping_model"].values.tolist() == list(MODELS)


def test_every_wall_is_shaken_to_the_same_scales(config, study):
    for motion in catalogue.load_records(RECORDS):
        found, one = intensity_measures(motion.record), study.sel(record=motion.name)
        for named in config.earthquakes.walls:
            wall, factor = named.wall, one["scale_factor"].sel(wall=named.name)
            p, u_ins = float(wall.frequency_parameter), float(wall.instability_displacement)
            velocity = wall.excitation_factor * factor * found.pgv
            np.testing.assert_allclose(velocity / (p * u_ins), study["velocity_ratio"], rtol=1e-12)


def test_restitution_has_one_answer_and_a_damper_without_a_ratio_none(study):
    cr = study.sel(damping_model="CR")
    for name in ("peak", "collapsed", "converged"):
        assert (cr[name] == cr[name].isel(damping_ratio_source=0)).all()
    missing = np.isnan(study["damping_ratio"]) & (study["damping_model"] != "CR")
    assert missing.any()
    assert ((study["collapsed"] == -1) == missing).all() and (np.isnan(study["peak"]) == missing).all()


def test_walls_stand_at_the_lowest_scale_and_collapse_at_the_highest(study):
    run = study["collapsed"].where(study["collapsed"] >= 0)
    assert run.isel(velocity_ratio=0).mean() < 0.05 and run.isel(velocity_ratio=-1).mean() > 0.9
    stands, peak = study["collapsed"] == 0, study["peak"]
    assert (peak.where(stands) <= 1.0).sum() == stands.sum()
    assert (peak.where(study["collapsed"] == 1) == 1.0).sum() == (study["collapsed"] == 1).sum()  # a3 is 1 here


@pytest.mark.no_cover
def test_histories_towards_collapse_agree_with_the_event_driven_solver_within_their_bound(config, study):
    few = changed(config, {"earthquakes.check.histories": 60, "earthquakes.check.seed": 1})
    found = event_driven_check.check_earthquakes(few, study)
    dataset.check(found, "earthquake_check")
    assert set(found["damping_model"].values) == set(MODELS)
    counts = dict(zip(found["stratum"].values.tolist(), found["checked_count"].values.tolist(), strict=True))
    assert counts == {
        "far": 12,
        "near": 12,
        "edge": 12,
        "just collapsed": 12,
        "unconverged": min(12, counts["unconverged"]),
    }
    certain = found.sel(stratum=["far", "near", "edge", "just collapsed"])
    assert (certain["otherwise_share"] == 0).all()
    assert (certain["beyond_bound_share"].dropna("stratum") == 0).all()
    assert (certain["median_difference"].dropna("stratum") < 0.002).all()
    stands = found.isel(history=((found["converged"] == 1) & (found["collapsed"] == 0)).values)
    assert stands.sizes["history"] > 20
    assert (stands["peak_uncertainty"] / stands["peak"]).median() < 0.005


def test_shares_of_the_records_change_nothing(config, walls):
    own, walls_of = walls.isel(wall=slice(1)), config.earthquakes.walls
    few = changed(config, {"records": ("fema-p695:far-field/[23]/a",), "earthquakes.walls": walls_of[:1]})

    ends = GeometricGrid(start=0.2, stop=5.0, count=2)

    def gathered(chunk, jobs):
        few_ = changed(few, {"earthquakes.chunk": chunk, "earthquakes.velocity_ratio": ends})
        return earthquakes.gather(few_, own, [earthquakes.chunk(number, few_, own) for number in jobs])

    xr.testing.assert_identical(gathered(1, "01"), gathered(2, "0"))


# --- what is made of them --------------------------------------------------------------------------------------------


def made_up(ratio):
    """A study of 40 records whose dampers' peaks are those of CR times `ratio`, collapsing beyond 1."""
    scale, capacity = np.geomspace(0.2, 5.0, 12), np.random.default_rng(5).lognormal(0.0, 0.4, (40, 2, 2))
    cr = 0.6 * scale[None, :, None, None] / capacity[:, None]
    factor = np.array([1.0] + [ratio] * len(VISCOUS_MODELS))
    peaks = cr[..., None, None] * factor[:, None] * np.ones(3)
    return histories(peaks, cr[..., None] * np.ones(4), [f"s{i // 2}" for i in range(40)], scale)


def test_peaks_in_proportion_have_that_ratio_and_move_the_fragility_by_it(config):
    found = comparison.compare_dampers(config, made_up(0.9))
    dataset.check(found, "comparison")
    dampers = found.sel(damping_model=list(VISCOUS_MODELS))
    np.testing.assert_allclose(dampers["median_ratio"].isel(band=0), 0.9, rtol=1e-12)
    np.testing.assert_allclose(dampers["median_ratio_interval"].isel(band=0), 0.9, rtol=1e-12)
    np.testing.assert_allclose(dampers["log_error"].isel(band=0), -np.log(0.9), rtol=1e-9)
    # The scales are stripes, so the median moves by the ratio only as far as the fit sees between them.
    np.testing.assert_allclose(dampers["median_intensity_ratio"], 1 / 0.9, rtol=0.03)
    low, high = (dampers["median_intensity_ratio_interval"].sel(bound=bound) for bound in comparison.BOUND)
    assert (low <= dampers["median_intensity_ratio"]).all() and (dampers["median_intensity_ratio"] <= high).all()
    assert (dampers["added_collapse_rate"] == 0).all() and (dampers["missed_collapse_rate"] > 0).all()


def test_bands_share_out_the_pairs(config, compared):
    assert (compared["pairs"].isel(band=slice(1, None)).sum("band") == compared["pairs"].isel(band=0)).all()
    edges = config.comparison.bands
    assert compared["band_start"].values.tolist() == [edges[0], *edges[:-1]]
    assert compared["band_end"].values.tolist() == [edges[-1], *edges[1:]]


def test_each_source_is_compared_on_the_walls_that_have_a_ratio_from_it(config, study, compared):
    """The polynomials have no ratio for one wall: their statistics are those of a study without it, the others' not."""
    missing = study["damping_ratio"].isnull().sel(damping_model="CDR").any("restitution")
    assert missing.sum() == 1 and bool(missing.sel(damping_ratio_source="polynomial").any())
    np.testing.assert_array_equal(compared["pooled"] == 1, ~missing)
    fewer = comparison.compare_dampers(config, study.isel(wall=~missing.any("damping_ratio_source").values))
    for name in (
        "log_error",
        "pairs",
        "missed_collapse_rate",
        "added_collapse_rate",
        "median_intensity_ratio_interval",
    ):
        of_source = {"damping_model": list(VISCOUS_MODELS), "damping_ratio_source": "polynomial"}
        of_all, of_fewer = (each[name].sel(of_source) for each in (compared, fewer))
        np.testing.assert_array_equal(of_all, of_fewer)
    of_source["damping_ratio_source"] = "closed form"
    pairs = [each["pairs"].isel(band=0).sel(of_source) for each in (compared, fewer)]
    assert (pairs[0] > pairs[1]).all()


def test_rates_of_a_source_count_the_histories_that_it_ran():
    """CR collapses both walls under the first record; the first wall has no ratio, which is no missed collapse."""
    fell = np.zeros((2, 1, 2, 2), dtype=bool)
    fell[0] = True
    other = np.where(fell, 1, 0).astype(np.int8)[..., None]
    other[:, :, 0] = -1
    reference = np.where(fell, 1.5, 0.5)
    dims = ("record", "velocity_ratio", "wall", "restitution")
    made = xr.Dataset(
        {
            "reference_peak": (dims, reference),
            "reference_collapsed": (dims, fell.astype(np.int8)),
            "peak": ((*dims, "source"), 1.1 * reference[..., None]),
            "collapsed": ((*dims, "source"), np.where(other == 1, 0, other)),
        }
    )
    found = compare_pairs(made, np.ones((3, 2)), [(0.0, np.inf)])
    assert (found["missed_collapse_rate"] == 1.0).all()
    assert (found["added_collapse_rate"] == 0.0).all() and (found["pairs"] == 1).all()

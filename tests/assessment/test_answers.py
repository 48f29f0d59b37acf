"""What is handed to NRML is what was found, of one wall and of a population; damping ratios of a table of walls."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtr

import rockdamp as rd
from rockdamp.assessment.answers import description, fragilities, population_fragilities, ratios, with_modelling
from rockdamp.assessment.table import read_walls
from rockdamp.errors import InputError, InputWarning

TABLE = """id,thickness,height,a1,b1,a3,softening,preset,restitution
north,0.25,3.0,0.06,0.7,0.95,translated,,0.9
bad,0.25,3.0,,,,,,0.85
south,0.25,3.0,,,,,moderate,0.9
low,0.25,3.0,0.04,0.85,0.4,,,0.9
late,0.25,3.0,0.04,0.012,,,,0.9
steep,0.25,3.0,0.06,0.7,0.95,steeper,,0.9
stiff,0.25,3.0,0.004,0.8,,,,0.9
"""
X0 = 0.5


def test_a_wall_has_a_function_of_its_stripes_for_each_damping_model(answer):
    functions = list(fragilities(answer, ["home"]))
    assert [function.name for function in functions] == ["home-CR", "home-ECD16"]
    for function, model in zip(functions, answer["damping_model"].values, strict=True):
        of_model = answer.sel(damping_model=model)
        assert (function.median, function.dispersion) == (float(of_model["median_pgv"]), float(of_model["dispersion"]))
        assert function.intensity == answer["stripe_pgv"].values.tolist()
        np.testing.assert_allclose(function.share, of_model["stripe_collapses"] / 14)
        assert function.share[0] == 0 and function.share[-1] == 1


def test_a_modelling_dispersion_is_that_of_two_independent_scatters(answer):
    """The share that collapses is the mean over a median that itself is lognormal."""
    (plain, _), modelling = fragilities(answer, ["home"]), 0.3
    wider = next(with_modelling([plain], modelling))
    draws = plain.median * np.exp(modelling * np.random.default_rng(1).standard_normal(200_000))
    for level, share in zip(wider.intensity, wider.share, strict=True):
        assert share == pytest.approx(ndtr(np.log(level / draws) / plain.dispersion).mean(), abs=5e-3)
    assert wider.dispersion == pytest.approx(np.sqrt(plain.dispersion**2 + 0.09), rel=1e-12)
    assert wider.median == plain.median and next(with_modelling([plain], 0)) is plain
    assert "record to record alone" in description(0) and "a modelling dispersion of 0.3" in description(0.3)


def test_stripes_without_a_function_stay_as_they_are(answer):
    (plain, _) = fragilities(answer, ["home"])
    bare = replace(plain, median=np.nan, dispersion=np.nan)
    with pytest.warns(InputWarning, match="'home-CR' has no lognormal function"):
        assert next(with_modelling([bare], 0.3)) is bare
    with pytest.raises(InputError, match="modelling_dispersion is 3; it must be between 0 and 2"):
        next(with_modelling([plain], 3))


def test_a_population_has_the_share_of_its_walls_and_records():
    population = xr.Dataset(
        {
            "median_intensity": ("damping_model", [0.5, 0.6]),
            "dispersion": ("damping_model", [0.4, 0.5]),
            "collapse_fraction": (("intensity", "damping_model"), [[0.0, 0.1], [0.7, 0.8]]),
        },
        coords={"damping_model": ["CR", "CDR"], "intensity": [0.2, 0.8]},
    )
    _, cdr = population_fragilities(population)
    assert cdr.name == "population-CDR" and (cdr.median, cdr.dispersion) == (0.6, 0.5)
    assert cdr.intensity == [0.2, 0.8] and cdr.share == [0.1, 0.8]


# --- damping ratios --------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    path = tmp_path_factory.mktemp("walls") / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    by_wall = {}
    for row in ratios(read_walls(path), X0):
        by_wall.setdefault(row["id"], []).append(row)
    return by_wall


@pytest.mark.parametrize(
    "name, curve",
    [
        ("north", (0.06, 0.7, 0.95, "translated")),
        ("south", (0.13, 0.60)),
        ("steep", (0.06, 0.7, 0.95)),
        ("stiff", (0.004, 0.8)),
    ],
)
def test_each_wall_has_the_ratios_that_equivalent_finds_for_it_alone(found, name, curve):
    """Of every damper, ECD among them: the same search, to the last bit on one machine."""
    alone = rd.equivalent(0.9, *curve, release_amplitude=X0)
    assert [(row["damping_model"], row["damping_ratio"], row["error"]) for row in found[name]] == [
        (row["damping_model"], row["damping_ratio"], "") for row in alone
    ]
    assert [row["restitution"] for row in found[name]] == [0.9] * len(alone)


def test_the_ratio_has_the_least_error_and_not_the_peaks(found):
    told = {row["damping_model"]: row["damping_ratio"] for row in found["south"]}
    exact = float(rd.Damping.of_restitution(0.9).damping_ratio)
    assert 1.001 < told["ECD"] / exact < 1.05


def test_walls_keep_their_order_and_a_row_without_a_wall_has_its_error_once(found):
    assert list(found) == ["north", "bad", "south", "low", "late", "steep", "stiff"]
    (bad,), (low,) = found["bad"], found["low"]
    assert bad["error"].startswith("line 3: a1 is empty") and bad["damping_ratio"] is None
    assert low["error"] == "line 5: release_amplitude is 0.5; it must be greater than 0 and less than a3"


def test_a_wall_without_a_least_error_says_why_and_stops_no_other(found):
    for row in found["late"]:
        assert row["damping_ratio"] is None
        assert row["error"].startswith("line 6: response_length is 8; it must be longer than")

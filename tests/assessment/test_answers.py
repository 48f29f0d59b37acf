"""What is handed to NRML is what was found, of one wall and of a population."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from scipy.special import ndtr

from rockdamp.assessment.answers import description, fragilities, population_fragilities, with_modelling
from rockdamp.errors import InputError, InputWarning


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

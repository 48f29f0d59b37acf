"""What is handed to NRML is what was found, of one wall and of a population."""

import numpy as np
import xarray as xr

from rockdamp.assessment.openquake import of_population, of_wall


def test_a_wall_has_a_function_of_its_stripes_for_each_damping_model(answer):
    functions = of_wall(answer, "home")
    assert [function.name for function in functions] == ["home-CR", "home-ECD16"]
    for function, model in zip(functions, answer["damping_model"].values, strict=True):
        of_model = answer.sel(damping_model=model)
        assert (function.median, function.dispersion) == (float(of_model["median_pgv"]), float(of_model["dispersion"]))
        assert function.intensity == answer["stripe_pgv"].values.tolist()
        np.testing.assert_allclose(function.share, of_model["stripe_collapses"] / 14)
        assert function.share[0] == 0 and function.share[-1] == 1


def test_a_population_has_the_share_of_its_walls_and_records():
    population = xr.Dataset(
        {
            "median_intensity": ("damping_model", [0.5, 0.6]),
            "dispersion": ("damping_model", [0.4, 0.5]),
            "collapse_fraction": (("intensity", "damping_model"), [[0.0, 0.1], [0.7, 0.8]]),
        },
        coords={"damping_model": ["CR", "CDR"], "intensity": [0.2, 0.8]},
    )
    _, cdr = of_population(population)
    assert cdr.name == "population-CDR" and (cdr.median, cdr.dispersion) == (0.6, 0.5)
    assert cdr.intensity == [0.2, 0.8] and cdr.share == [0.1, 0.8]

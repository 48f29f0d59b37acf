"""The report's tables: their numbers are those of the datasets."""

import made_up_earthquakes as made_up
import made_up_studies
import numpy as np
import pytest
import xarray as xr

from rockdamp.constants import RECOMMENDED_SOURCE, VISCOUS_MODELS
from rockdamp.equivalence.programs import REQUIREMENT
from rockdamp.figures.style import RESTITUTION
from rockdamp.report import tables
from rockdamp.text import number, percent


def test_code_in_a_cell_is_shown_as_code_and_markup_as_text():
    assert tables.inline("`solve` if a < b") == "<code>solve</code> if a &lt; b"
    assert tables.inline("-3% of u_ins, large-rotation, -a") == "−3&nbsp;% of u<sub>ins</sub>, large-rotation, -a"


# --- dampers ---------------------------------------------------------------------------------------------------------


def test_each_damper_that_is_shown_has_a_row_with_its_force_errors_and_step():
    study = made_up_studies.order()
    at_e, told = study.sel(restitution=RESTITUTION, method="nearest"), tables.order(study)
    rows = {row["damper"]: row for row in told["rows"]}
    assert list(rows)[:4] == ["ECD", "ECD16", "ECD64", "BAND0.4"] and list(rows)[-1] == "CR, e + 0.01"
    for damper in ("ECD", "BAND0.2", "CQD0.25"):
        one, row = at_e.sel(damper=damper), rows[damper]
        assert float(row["force"]) == pytest.approx(float(one["crossing_force"].sel(wall="paper")), rel=0.06)
        for text, variable in zip(row["errors"], tables.ORDER_COLUMNS.values(), strict=True):
            assert str(text).startswith(percent(one[variable])) and text.count("to") == 1
        assert row["step"] == "0.05"
    assert rows["CR, e - 0.01"]["force"] == "–"
    for name in ("share_above", "missed_collapse_rate", "added_collapse_rate"):
        assert told[name] == percent(at_e[name].sel(damper="BAND0.2"))
    assert told["half_step"] == percent(at_e["share_above"].sel(damper="half step"))


def test_a_program_s_damper_has_its_errors_with_the_leading_ratio():
    compared = made_up.comparison()
    leading = compared.sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    rows = tables.programs(compared)
    assert [row["model"] for row in rows] == list(REQUIREMENT)
    for row in rows:
        for errors, name in zip(row["errors"], tables.PROGRAM_COLUMNS, strict=True):
            assert errors == [percent(value) for value in leading[name].sel(damping_model=row["model"]).values]


def test_the_selection_of_histories_counts_walls_and_records():
    compared = made_up.comparison()
    compared["pooled"][:2] = 0  # beside one that has no ratio
    told = tables.selection(compared.assign(records=7))
    assert told.startswith("2 walls under 7 earthquake records, peaks of 0.01 to 1")


def test_the_sliders_have_the_stored_ratios_and_what_lies_between():
    fits = made_up_studies.equivalence()
    stored = tables.ratios(fits.isel(yield_displacement_ratio=slice(None, None, -1)))
    xi = fits["damping_ratio"]
    np.testing.assert_allclose(stored["e"], xi["restitution"])
    np.testing.assert_allclose(stored["a1"], np.sort(xi["yield_displacement_ratio"]))
    for model in REQUIREMENT:
        np.testing.assert_allclose(stored["ratio"][model], xi.sel(damping_model=model), atol=1e-6)
        e, a1 = np.mean(stored["e"][:2]), np.mean(stored["a1"][:2])
        between = float(xi.sel(damping_model=model)[:2, :2].mean())
        assert float(tables.ratio_at(stored, model, e, a1)) == pytest.approx(100 * between, abs=0.006)
    fits["damping_ratio"].loc[{"damping_model": "CDC"}] = np.nan
    assert tables.ratio_at(tables.ratios(fits), "CDC", 0.85, 0.04) == "–"


# --- earthquakes, assumptions and trials -----------------------------------------------------------------------------


def test_what_was_run_is_counted_from_the_datasets():
    walls, compared = made_up.walls(), made_up.comparison()
    each = int(np.isfinite(walls["damping_ratio"]).sum()) + len(made_up.WALLS) * made_up.E.size
    told = tables.earthquakes(compared, walls)
    assert told["histories"].replace("\u202f", "") == str(100 * made_up.SCALE.size * each)
    assert (told["records"], told["stations"], told["few"], told["converged"]) == (100, 50, False, "99.00")
    assert [row[0] for row in told["walls"]] == made_up.WALLS and len(told["walls"][0]) == 10


def test_errors_collapses_and_bands_are_those_of_the_leading_ratio():
    compared = made_up.comparison()
    at = {"damping_model": "CDR", "damping_ratio_source": "least error", "restitution": 0.85}
    for name, value in (("median_ratio", 1.23), ("log_error_median", 0.45), ("log_error_90", 0.67)):
        compared[name].loc[{**at, "band": 2}] = value
    told = tables.earthquakes(compared, made_up.walls())
    assert [row[:2] for row in told["errors"]] == [(f"{e:g}", model) for e in made_up.E for model in VISCOUS_MODELS]
    for at_e, model, (median, *_, missed, added, _) in told["errors"]:
        assert median.startswith(number(made_up.FACTOR[made_up.MODELS.index(model)])), (at_e, model)
        assert missed.startswith("3\u00a0%") and added.startswith("2\u00a0%")  # of collapses, and of survivals
    assert dict(told["by_band"])["CDR"][1] == "1.23; 0.45; 0.67" and told["middle"] == "0.85"


def test_a_study_too_small_for_any_number_has_dashes():
    compared = made_up.comparison()
    statistics = [key for key, values in compared.data_vars.items() if values.dtype.kind == "f"]
    compared = compared.assign({key: compared[key] * np.nan for key in statistics} | {"converged_share": 1.0})
    told = str(tables.earthquakes(compared, made_up.walls()))
    assert "nan" not in told and "–" in told


def test_an_assumption_is_unsafe_where_its_interval_lies_below_one():
    ratio = xr.DataArray([[0.8, 0.5], [1.2, 0.5], [1.0, 0.5]], dims=("assumption", "wall"))
    bounds = ratio.expand_dims(bound=2, axis=-1) + np.array([-0.1, 0.1])
    study = xr.Dataset(
        {"median_intensity_ratio": ratio, "median_intensity_ratio_interval": bounds},
        coords={"assumption": ["one", "two", "three"], "wall": ["all", "church"]},
    )
    assert [(name, side) for name, _, side in tables.supports(study)] == [
        ("one", "unsafe"),
        ("two", "safe"),
        ("three", "neither"),
    ]


def test_a_constant_e_of_small_releases_overstates_by_the_inverse_of_the_ratio():
    """A wall that survives 1/1.25, 1/1.10 and 1/1.50 of what the constant e says: it overstates by 25, 10 and 50 %."""
    study = made_up_studies.loss_law()
    dims = study["median_intensity_ratio"].dims[1:]
    ratio = xr.DataArray([[1.1, 1.0, 1.0], [1.25, 1.02, 0.98], [1.5, 1, 0.97]], dims=dims)
    study["median_intensity_ratio"][:] = 1 / ratio
    told = tables.loss_law(study)
    assert (told["overstates"], told["within"]) == ("10\u00a0% to 50\u00a0%", "3.0\u00a0%")
    assert (told["small"], told["good"]) == ("0.1", "0.3 to 0.5")


def test_measured_trials_reject_one_e_by_the_likelihood_ratio():
    likelihood = {"CR": [100.0, 196.0], "CDC": [90.0, 180.0], "CDR": [98.0, 195.0], "SDR": [99.0, 199.0]}
    likelihood["power law"] = [100.5, 200.0]
    told = tables.measured_rocking(
        xr.Dataset(
            {
                "log_likelihood": (("damping_model", "impacts_used"), list(likelihood.values())),
                "amplitude_exponent": ("impacts_used", [-0.1, -0.3]),
                "trials": 130,
                "duplicates": 4,
            },
            coords={"damping_model": list(likelihood), "impacts_used": [6, 10]},
        )
    )
    assert told["p"] == ["0.32", "0.0047"] and told["trials"] == 126  # chi-square of 1 and of 8
    assert "5 % with 10 impacts" in told["sentences"][3]
    assert "−4 to −1" in told["sentences"][0] and "1 to 4" in told["sentences"][1]
    assert dict(told["rows"])["SDR"] == ["1", "0"]

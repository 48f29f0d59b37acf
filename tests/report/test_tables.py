"""The report's tables: their numbers are those of the datasets."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.constants import RECOMMENDED_SOURCE, VISCOUS_MODELS
from rockdamp.equivalence.programs import REQUIREMENT
from rockdamp.figures.style import RESTITUTION
from rockdamp.report import tables
from rockdamp.storage import dataset
from rockdamp.text import number, percent


@pytest.fixture
def read(minimal):
    return lambda name: dataset.read(minimal / f"{name}.nc").load()


def test_code_in_a_cell_is_shown_as_code_and_markup_as_text():
    assert tables.inline("`solve` if a < b") == "<code>solve</code> if a &lt; b"
    assert (
        tables.inline("-3% of u_ins, large-rotation, -a")
        == "−3&nbsp;% of u<sub>ins</sub>, large-rotation, -a"
    )


# --- dampers ---------------------------------------------------------------------------------------------------------


def test_each_damper_of_the_table_has_its_force_errors_and_step(read):
    study = read("order")
    study["largest_step"][:] = 0.05
    at_e, shown = study.sel(restitution=RESTITUTION, method="nearest"), tables.order(study)
    rows = {row["damper"]: row for row in shown["rows"]}
    assert list(rows) == [
        "ECD",
        "ECD16",
        "BAND0.4",
        "BAND0.2",
        "CQD0.25",
        "CR, e - 0.01",
        "CR, e + 0.01",
    ]
    for damper in ("ECD", "BAND0.2", "CQD0.25"):
        one, row = at_e.sel(damper=damper), rows[damper]
        assert float(row["force"]) == pytest.approx(
            float(one["crossing_force"].sel(wall="paper")), rel=0.06
        )
        for text, variable in zip(row["errors"], tables.ORDER_COLUMNS.values(), strict=True):
            assert str(text).startswith(percent(one[variable]))
        assert row["step"] == "0.05"
    assert rows["CR, e - 0.01"]["force"] == "–"
    for name in ("share_above", "missed_collapse_rate", "added_collapse_rate"):
        assert shown[name] == percent(at_e[name].sel(damper="BAND0.2"))
    assert shown["half_step"] == percent(at_e["share_above"].sel(damper="half step"))


def test_a_program_s_damper_has_its_errors_with_the_recommended_ratio(read):
    compared = read("comparison")
    leading = compared.sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    rows = tables.programs(compared)
    assert [row["model"] for row in rows] == list(REQUIREMENT)
    for row in rows:
        for errors, name in zip(row["errors"], tables.PROGRAM_COLUMNS, strict=True):
            assert errors == [
                percent(value) for value in leading[name].sel(damping_model=row["model"]).values
            ]


def test_the_selection_of_histories_counts_walls_and_records(read):
    compared = read("comparison").assign(records=7)
    compared["pooled"][:] = 1
    compared["pooled"][0] = 0
    assert tables.selection(compared).startswith(
        "1 wall under 7 earthquake records, peaks of 0.01 to 1 "
    )


def test_the_sliders_have_the_stored_ratios_and_what_lies_between(read):
    fits = read("equivalence")
    stored = tables.ratios(fits.isel(yield_displacement_ratio=slice(None, None, -1)))
    xi = fits["damping_ratio"]
    np.testing.assert_allclose(stored["e"], xi["restitution"])
    np.testing.assert_allclose(stored["a1"], np.sort(xi["yield_displacement_ratio"]))
    for model in REQUIREMENT:
        np.testing.assert_allclose(stored["ratio"][model], xi.sel(damping_model=model), atol=1e-6)
        e, a1 = np.mean(stored["e"][:2]), np.mean(stored["a1"][:2])
        between = float(xi.sel(damping_model=model)[:2, :2].mean())
        assert float(tables.ratio_at(stored, model, e, a1)) == pytest.approx(
            100 * between, abs=0.006
        )
    fits["damping_ratio"].loc[{"damping_model": "CDC"}] = np.nan
    assert tables.ratio_at(tables.ratios(fits), "CDC", 0.85, 0.04) == "–"


# --- earthquakes, assumptions and trials -----------------------------------------------------------------------------


def test_errors_collapses_and_bands_are_those_of_the_recommended_ratio(read):
    compared, walls = read("comparison"), read("earthquakes/walls")
    at = {"damping_model": "CDR", "damping_ratio_source": RECOMMENDED_SOURCE}
    for name, value in (("median_ratio", 1.23), ("log_error_median", 0.45), ("log_error_90", 0.67)):
        compared[name].loc[{**at, "band": [0, 2]}] = value
    compared["missed_collapse_rate"].loc[at], compared["added_collapse_rate"].loc[at] = 0.03, 0.02
    shown = tables.earthquakes(compared.assign(converged_share=0.99), walls)
    e = compared["restitution"].values
    assert [row[:2] for row in shown["errors"]] == [
        (f"{value:g}", model) for value in e for model in VISCOUS_MODELS
    ]
    for _, model, (median, at_median, at_90, missed, added, _) in shown["errors"]:
        if model == "CDR":
            assert (at_median, at_90) == (number(0.45), number(0.67)) and str(median).startswith(
                "1.23"
            )
            assert str(missed).startswith("3\u00a0%") and str(added).startswith("2\u00a0%")
    assert (
        dict(shown["by_band"])["CDR"][1] == number(0.67)
        and shown["middle"] == f"{e[e.size // 2]:g}"
    )
    runs = int(np.isfinite(walls["damping_ratio"]).sum()) + walls.sizes["wall"] * e.size
    histories = int(compared["records"]) * compared.sizes["velocity_ratio"] * runs
    assert (
        shown["histories"].replace("\u202f", "") == str(histories) and shown["converged"] == "99.00"
    )
    assert [row[0] for row in shown["walls"]] == walls["wall"].values.tolist() and shown["few"]


def test_a_study_too_small_for_any_number_has_dashes(read):
    compared = read("comparison")
    statistics = [key for key, values in compared.data_vars.items() if values.dtype.kind == "f"]
    compared = compared.assign(
        {key: compared[key] * np.nan for key in statistics} | {"converged_share": 1.0}
    )
    shown = str(tables.earthquakes(compared, read("earthquakes/walls"))["errors"])
    assert "nan" not in shown and "–" in shown


def test_an_assumption_is_unsafe_where_its_interval_lies_below_one():
    ratio = xr.DataArray([[0.8, 0.5], [1.2, 0.5], [1.0, 0.5]], dims=("assumption", "wall"))
    bounds = ratio.expand_dims(bound=2, axis=-1) + np.array([-0.1, 0.1])
    study = xr.Dataset(
        {"median_intensity_ratio": ratio, "median_intensity_ratio_interval": bounds},
        coords={"assumption": ["one", "two", "three"], "wall": ["all", "church"]},
    )
    sides = [("one", "unsafe"), ("two", "safe"), ("three", "neither")]
    assert [(name, side) for name, _, side in tables.supports(study)] == sides


def test_a_constant_e_of_small_releases_overstates_by_the_inverse_of_the_ratio():
    """A wall that survives 1/1.25, 1/1.10 and 1/1.50 of what the constant e says: it overstates by 25, 10 and 50 %."""
    ratio = 1 / np.array([[1.1, 1.0, 1.0], [1.25, 1.02, 0.98], [1.5, 1, 0.97]])
    study = xr.Dataset(
        {"median_intensity_ratio": (("wall", "loss_exponent", "reference_amplitude"), ratio[None])},
        coords={
            "wall": ["all"],
            "loss_exponent": [0.13, 0.26, 0.39],
            "reference_amplitude": [0.1, 0.3, 0.5],
            "restitution": 0.85,
        },
    )
    shown = tables.loss_law(study)
    assert (shown["overstates"], shown["within"]) == ("10\u00a0% to 50\u00a0%", "3.0\u00a0%")
    assert (shown["small"], shown["good"]) == ("0.1", "0.3 to 0.5")


def test_measured_trials_reject_one_e_by_the_likelihood_ratio():
    likelihood = {
        "CR": [100.0, 196.0],
        "CDC": [90.0, 180.0],
        "CDR": [98.0, 195.0],
        "SDR": [99.0, 199.0],
    }
    likelihood["power law"] = [100.5, 200.0]
    shown = tables.measured_rocking(
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
    assert shown["p"] == ["0.32", "0.0047"] and shown["trials"] == 126  # chi-square of 1 and of 8
    assert "with 10 impacts" in shown["sentences"][3]
    assert "−4 to −1" in shown["sentences"][0] and "1 to 4" in shown["sentences"][1]
    assert dict(shown["rows"])["SDR"] == ["1", "0"]

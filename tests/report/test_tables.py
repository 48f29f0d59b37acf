"""The report's tables have the numbers of the datasets."""

import numpy as np
import pytest
import xarray as xr
from made_datasets import make_dataset

from rockdamp.constants import RECOMMENDED_SOURCE, VISCOUS_MODELS
from rockdamp.equivalence.programs import REQUIREMENT
from rockdamp.figures.style import RESTITUTION
from rockdamp.report import tables
from rockdamp.storage import dataset
from rockdamp.text import percent


@pytest.fixture
def read(minimal):
    return lambda name: dataset.read(minimal / f"{name}.nc").load()


def test_code_in_a_cell_is_code_and_markup_is_text():
    assert tables.inline("`solve` if a < b") == "<code>solve</code> if a &lt; b"


def test_minus_per_cent_and_index_in_a_cell():
    html = tables.inline("-3% of u_ins, large-rotation, -a")
    assert html == "−3&nbsp;% of u<sub>ins</sub>, large-rotation, -a"


# --- dampers -----------------------------------------------------------------------------------


@pytest.fixture
def order(read):
    study = read("order")
    study["largest_step"][:] = 0.05
    return study


def test_order_has_its_dampers_and_restitution_with_another_e(order):
    names = [row["damper"] for row in tables.order(order)["rows"]]
    band = ["ECD", "ECD16", "BAND0.4", "BAND0.2", "CQD0.25"]
    assert names == [*band, "CR, e - 0.01", "CR, e + 0.01"]


@pytest.mark.parametrize("damper", ["ECD", "BAND0.2", "CQD0.25"])
def test_damper_of_order_has_its_force_errors_and_step(order, damper):
    (row,) = (row for row in tables.order(order)["rows"] if row["damper"] == damper)
    stored = order.sel(restitution=RESTITUTION, method="nearest").sel(damper=damper)
    force = float(stored["crossing_force"].sel(wall="paper"))
    assert float(row["force"]) == pytest.approx(force, rel=0.06)
    for text, variable in zip(row["errors"], tables.ORDER_COLUMNS.values(), strict=True):
        assert str(text).startswith(percent(stored[variable]))
    assert row["step"] == "0.05"


def test_restitution_with_another_e_has_no_force(order):
    (row,) = (row for row in tables.order(order)["rows"] if row["damper"] == "CR, e - 0.01")
    assert row["force"] == "–"


def test_limits_of_the_recommended_damper(order):
    values = tables.order(order)
    stored = order.sel(restitution=RESTITUTION, method="nearest")
    for name in ("share_above", "missed_collapse_rate", "added_collapse_rate"):
        assert values[name] == percent(stored[name].sel(damper="BAND0.2"))
    assert values["half_step"] == percent(stored["share_above"].sel(damper="half step"))


def test_damper_of_a_program_has_the_recommended_ratio(read):
    compared = read("comparison")
    leading = compared.sel(damping_ratio_source=RECOMMENDED_SOURCE).isel(band=0)
    rows = tables.programs(compared)
    assert [row["model"] for row in rows] == list(REQUIREMENT)
    for row in rows:
        stored = leading.sel(damping_model=row["model"])
        for errors, name in zip(row["errors"], tables.PROGRAM_COLUMNS, strict=True):
            assert errors == [percent(value) for value in stored[name].values]


def test_selection_counts_walls_and_records(read):
    compared = read("comparison").assign(records=7)
    compared["pooled"][:] = 1
    compared["pooled"][0] = 0
    selection = tables.selection(compared)
    assert selection.startswith("1 wall under 7 earthquake records, peaks of 0.01 to 1 ")


def test_sliders_have_the_stored_ratios(read):
    fits = read("equivalence")
    stored = tables.ratios(fits.isel(yield_displacement_ratio=slice(None, None, -1)))
    xi = fits["damping_ratio"]
    np.testing.assert_allclose(stored["e"], xi["restitution"])
    np.testing.assert_allclose(stored["a1"], np.sort(xi["yield_displacement_ratio"]))
    for model in REQUIREMENT:
        expected = xi.sel(damping_model=model)
        np.testing.assert_allclose(stored["ratio"][model], expected, atol=1e-6)


@pytest.mark.parametrize("model", REQUIREMENT)
def test_sliders_interpolate_the_ratios(read, model):
    fits = read("equivalence")
    stored = tables.ratios(fits)
    e = np.mean(stored["e"][:2])
    a1 = np.mean(stored["a1"][:2])
    between = float(fits["damping_ratio"].sel(damping_model=model)[:2, :2].mean())
    shown = float(tables.ratio_at(stored, model, e, a1))
    assert shown == pytest.approx(100 * between, abs=0.006)


def test_model_without_ratios_has_a_dash(read):
    fits = read("equivalence")
    fits["damping_ratio"].loc[{"damping_model": "CDC"}] = np.nan
    assert tables.ratio_at(tables.ratios(fits), "CDC", 0.85, 0.04) == "–"


# --- earthquakes -------------------------------------------------------------------------------

CDR = {"damping_model": "CDR", "damping_ratio_source": RECOMMENDED_SOURCE}


@pytest.fixture
def compared(read):
    """The comparison, with numbers of CDR that are known."""
    study = read("comparison")
    for name, value in {
        "median_ratio": 1.23,
        "log_error_median": 0.45,
        "log_error_90": 0.67,
    }.items():
        study[name].loc[{**CDR, "band": [0, 2]}] = value
    study["missed_collapse_rate"].loc[CDR] = 0.03
    study["added_collapse_rate"].loc[CDR] = 0.02
    return study.assign(converged_share=0.99)


def test_errors_and_collapses_of_a_damper(read, compared):
    values = tables.earthquakes(compared, read("earthquakes/walls"))
    for _, model, cells in values["errors"]:
        if model == "CDR":
            starts = ["1.23", "45\u00a0%", "67\u00a0%", "3\u00a0%", "2\u00a0%"]
            texts = [str(cell) for cell in cells]
            assert all(text.startswith(start) for text, start in zip(texts, starts, strict=False))


def test_errors_have_a_row_for_each_e_and_damper(read, compared):
    values = tables.earthquakes(compared, read("earthquakes/walls"))
    e = compared["restitution"].values
    expected = [(f"{value:g}", model) for value in e for model in VISCOUS_MODELS]
    assert [row[:2] for row in values["errors"]] == expected


def test_errors_by_band_are_those_of_the_middle_e(read, compared):
    values = tables.earthquakes(compared, read("earthquakes/walls"))
    e = compared["restitution"].values
    assert dict(values["by_band"])["CDR"][1] == percent(0.67)
    assert values["middle"] == f"{e[e.size // 2]:g}"


def test_histories_are_those_of_every_ratio_and_cr(read, compared):
    walls = read("earthquakes/walls")
    values = tables.earthquakes(compared, walls)
    runs = int(np.isfinite(walls["damping_ratio"]).sum())
    runs += walls.sizes["wall"] * compared.sizes["restitution"]
    histories = int(compared["records"]) * compared.sizes["velocity_ratio"] * runs
    assert values["histories"].replace("\u202f", "") == str(histories)
    assert values["converged"] == "99.00"


def test_walls_and_few_stations_are_named(read, compared):
    walls = read("earthquakes/walls")
    values = tables.earthquakes(compared, walls)
    assert [row[0] for row in values["walls"]] == walls["wall"].values.tolist()
    assert values["few"]


def test_study_too_small_for_a_number_has_dashes(read):
    compared = read("comparison")
    for name, values in compared.data_vars.items():
        if values.dtype.kind == "f":
            compared[name] = values * np.nan
    compared["converged_share"] = 1.0
    cells = str(tables.earthquakes(compared, read("earthquakes/walls"))["errors"])
    assert "nan" not in cells
    assert "–" in cells


# --- assumptions and trials --------------------------------------------------------------------


def test_assumption_is_unsafe_where_its_interval_lies_below_one():
    ratio = xr.DataArray([[0.8, 0.5], [1.2, 0.5], [1.0, 0.5]], dims=("assumption", "wall"))
    study = make_dataset(
        "supports",
        {"assumption": ["one", "two", "three"], "wall": ["all", "church"]},
        median_intensity_ratio=ratio.values,
    )
    bounds = ratio.expand_dims(bound=2, axis=-1) + np.array([-0.1, 0.1])
    study["median_intensity_ratio_interval"] = bounds
    sides = [("one", "unsafe"), ("two", "safe"), ("three", "neither")]
    assert [(name, side) for name, _, side in tables.supports(study)] == sides


def test_constant_e_overstates_by_the_inverse_of_the_ratio():
    """A wall that survives 1/1.25 of the intensity with the constant e: overstated by 25 %."""
    excess = np.array([[1.1, 1.0, 1.0], [1.25, 1.02, 0.98], [1.5, 1.0, 0.97]])
    study = make_dataset(
        "loss_law",
        {
            "wall": ["all"],
            "loss_exponent": [0.13, 0.26, 0.39],
            "reference_amplitude": [0.1, 0.3, 0.5],
            "restitution": 0.85,
        },
        median_intensity_ratio=1 / excess[None],
    )
    values = tables.loss_law(study)
    assert values["overstates"] == "10\u00a0% to 50\u00a0%"
    assert values["within"] == "3.0\u00a0%"
    assert (values["small"], values["good"]) == ("0.1", "0.3 to 0.5")


def test_loss_law_of_one_amplitude_has_no_numbers(read):
    study = read("loss_law").isel(reference_amplitude=[0])
    assert tables.loss_law(study) is None


@pytest.fixture
def trials():
    likelihood = {
        "CR": [100.0, 196.0],
        "CDC": [90.0, 180.0],
        "CDR": [98.0, 195.0],
        "SDR": [99.0, 199.0],
        "power law": [100.5, 200.0],
    }
    study = make_dataset(
        "measured_rocking",
        {"damping_model": list(likelihood), "impacts_used": [6, 10]},
        log_likelihood=list(likelihood.values()),
        amplitude_exponent=("impacts_used", [-0.1, -0.3]),
        trials=130,
        duplicates=4,
    )
    return tables.measured_rocking(study)


def test_trials_reject_one_e_by_the_likelihood_ratio(trials):
    """Twice the difference of ln L is 1 and 8: chi-square of one degree of freedom."""
    assert trials["p"] == ["0.32", "0.0047"]
    assert "with 10 impacts" in trials["sentences"][2]


def test_trials_leave_duplicates_out(trials):
    assert trials["trials"] == 126


def test_trials_compare_the_dampers(trials):
    assert "by 1 to 4" in trials["sentences"][0]
    assert "by 8 to 15" in trials["sentences"][1]
    assert dict(trials["rows"])["SDR"] == ["1", "0"]

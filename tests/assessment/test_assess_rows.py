"""Many walls: each is what it is alone, whatever runs beside it, and what is written holds no more than was found."""

import csv
import io

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.assessment import assess
from rockdamp.assessment.answers import COLUMNS, lines
from rockdamp.assessment.assess import assess_rows, median_peak
from rockdamp.assessment.table import BadRow, read_walls
from rockdamp.storage import dataset as storage

TABLE = """id,thickness,height,overburden_ratio,parapet,a1,b1,a3,softening,preset,restitution
a,0.25,3.0,0.5,,,,,,new,0.85
bad,,3.0,,,,,,,new,
b,0.2,1.2,,yes,,,,,severe,
c,0.30,4.5,1,,0.04,0.80,0.9,translated,,0.80
d,0.12,2.9,0,,0.03,0.80,,,,0.90
e,0.50,4.0,2,,,,,,severe,
"""


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("walls") / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    return read_walls(path)


@pytest.fixture(scope="module")
def found(rows, motions):
    return assess_rows(rows, motions, "PGV", 0.5)


def test_each_wall_is_what_assess_says_of_it_alone(rows, found, motions):
    for row in rows:
        one = found.sel(wall=row.id)
        if isinstance(row, BadRow):
            assert one["row_error"].item() == row.error and np.isnan(one["dispersion"]).all()
            continue
        alone = rd.assess(row.wall, row.curve, motions, pgv=0.5, restitution=row.restitution)
        assert not one["row_error"].item()
        np.testing.assert_array_equal(one["collapses"], alone["collapses"][:, 0])
        for name in ("rocking_onset", "damping_ratio", "order", "stripe_collapses", "unconverged", "restitution"):
            np.testing.assert_array_equal(one[name], alone[name])
        for name in ("median_pgv", "dispersion", "median_uncertainty", "dispersion_uncertainty"):
            np.testing.assert_allclose(one[name], alone[name], rtol=1e-8)
        peaks = np.median(alone["peak"].fillna(np.inf)[..., 0], axis=1)
        np.testing.assert_array_equal(one["peak_median"], np.where(np.isinf(peaks), np.nan, peaks))


def test_how_many_run_at_once_changes_nothing(rows, found, motions):
    xr.testing.assert_identical(assess_rows(rows, motions, "PGV", 0.5, chunk=2), found)


def test_a_wall_that_the_solver_refuses_stops_no_other(rows, found, motions, monkeypatch):
    real = assess.collapses

    def refusing(wall, *arguments, **options):
        if np.any(np.asarray(wall.thickness) == 0.12):
            raise rd.InputError("a history would take too long")
        return real(wall, *arguments, **options)

    monkeypatch.setattr(assess, "collapses", refusing)
    other = assess_rows(rows, motions, "PGV", 0.5)
    assert other["row_error"].sel(wall="d").item() == "line 6: a history would take too long"
    assert (other["collapses"].sel(wall="d") == -1).all() and np.isnan(other["restitution"].sel(wall="d"))
    xr.testing.assert_identical(other.sel(wall=list("abce")), found.sel(wall=list("abce")))


def test_a_table_without_a_wall_says_why(rows, motions):
    with pytest.raises(rd.InputError, match="no row could be computed; line 3: thickness is empty"):
        assess_rows(rows[1:2], motions, "PGV", 0.5)


def test_a_row_without_a_fragility_says_why_by_its_own_counts(found):
    """Of two walls and two models one pair has collapses that become fewer; those of the others are separated."""
    made = found.sel(wall=["a", "b"]).copy(deep=True)
    made["median_pgv"][:] = np.nan
    stripes = made.sizes["stripe"]
    made["stripe_collapses"][:] = np.where(np.arange(stripes) < 1, 0, 14)
    made["stripe_collapses"].loc[{"wall": "a", "damping_model": "BAND"}] = np.where(np.arange(stripes) < 1, 14, 0)
    fewer = [(row["id"], row["damping_model"]) for row in lines(made) if "fewer" in row["reason"]]
    assert fewer == [("a", "BAND")]
    assert all(
        "none below it" in row["reason"] for row in lines(made) if (row["id"], row["damping_model"]) not in fewer
    )


def test_the_table_has_a_row_for_each_damping_model_and_one_for_a_bad_row(found):
    table = list(lines(found))
    assert all(list(row) == list(COLUMNS) for row in table)
    assert [row["id"] for row in table] == ["a", "a", "bad", "b", "b", "c", "c", "d", "d", "e", "e"]
    text = io.StringIO()
    csv.DictWriter(text, COLUMNS).writerows(table)
    assert "nan" not in text.getvalue()
    (bad,) = (row for row in table if row["error"])
    assert bad["error"].startswith("line 3: thickness is empty") and bad["collapses"] == ""
    first = table[0]
    assert (first["damping_model"], first["damping_ratio"], first["records"]) == ("CR", "", 14)
    assert first["median_intensity"] == found["median_pgv"].values[0, 0]
    assert first["collapses"] == found["collapses"].values[0, 0]


def test_where_half_of_the_records_collapse_a_wall_there_is_no_median_peak(rows, motions):
    strong = assess_rows(rows[:1], motions, "PGV", 5.0)
    assert strong["collapses"].values.tolist() == [[14, 14]] and np.isnan(strong["peak_median"]).all()
    peaks = xr.Dataset({"peak": (("record", "wall"), [[0.1, 0.1], [0.2, 0.2], [np.nan, 0.4], [np.nan, np.nan]])})
    np.testing.assert_allclose(median_peak(peaks), [np.nan, 0.3])


def test_of_several_buildings_each_wall_has_the_answer_of_its_worst(rows, motions):
    few, buildings = motions[:2], [rd.Building(period, 3, 3) for period in (0.15, 0.5)]
    each = [assess_rows(rows, few, "PGV", 0.5, buildings=[building]) for building in buildings]
    both = assess_rows(rows, few, "PGV", 0.5, buildings=buildings)
    for index, row in enumerate(rows):
        if isinstance(row, BadRow):
            assert np.isnan(both["building_period"][index])
            continue
        cr = [answer.isel(wall=index).sel(damping_model="CR") for answer in each]
        counts = [int(one["collapses"]) for one in cr]
        period = float(both["building_period"][index])
        assert int(both["collapses"][index, 0]) == max(counts)
        if counts[0] != counts[1]:
            assert period == buildings[int(np.argmax(counts))].period
        else:
            medians = [float(one["median_pgv"].fillna(np.inf)) for one in cr]
            assert period == buildings[int(np.argmin(medians))].period


@pytest.mark.parametrize("measure", ["PGV", "PGA"])
def test_as_a_dataset_it_is_what_the_glossary_says(rows, motions, measure, tmp_path):
    made = assess_rows(rows, motions[:2], measure, 0.5)
    storage.write(made, tmp_path / "walls.nc", "batch", config={}, code_version="test")
    read = storage.read(tmp_path / "walls.nc")
    assert read["wall"].values.tolist() == ["a", "bad", "b", "c", "d", "e"]
    assert read["collapses"].sel(wall="bad").values.tolist() == [-1, -1]
    assert str(read["row_error"].sel(wall="bad").item()).startswith("line 3")
    np.testing.assert_array_equal(read["dispersion"], made["dispersion"])

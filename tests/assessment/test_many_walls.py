"""Many walls: each is what it is alone, whatever runs beside it, and what is written holds no more than was found."""

import csv
import io

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.assessment import many_walls
from rockdamp.assessment.many_walls import COLUMNS, MODELS, Answer, answers, dataset, fragilities, lines
from rockdamp.assessment.table import BadRow, read_walls
from rockdamp.plausibility import as_meant
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
    return list(answers(rows, motions, "PGV", 0.5))


def test_each_wall_is_what_assess_says_of_it_alone(rows, found, motions):
    for row, one in zip(rows, found, strict=True):
        if isinstance(row, BadRow):
            assert one is row
            continue
        with as_meant():  # the last of them does not rock under most of these records
            alone = rd.assess(row.wall, row.curve, motions, pgv=0.5, restitution=row.restitution)
        assert one.rocking_onset == float(alone["rocking_onset"])
        np.testing.assert_array_equal(one.collapses, alone["collapses"][:, 0])
        np.testing.assert_allclose(one.median, alone["median_pgv"], rtol=1e-8)
        np.testing.assert_allclose(one.dispersion, alone["dispersion"], rtol=1e-8)
        peaks = np.median(alone["peak_ratio"].fillna(np.inf)[..., 0], axis=1)
        np.testing.assert_array_equal(one.peak_ratio_median, np.where(np.isinf(peaks), np.nan, peaks))
        np.testing.assert_allclose(one.stripe_share, alone["stripe_collapses"] / 14)


def test_how_many_run_at_once_changes_nothing(rows, found, motions):
    for other, one in zip(answers(rows, motions, "PGV", 0.5, walls=2), found, strict=True):
        if isinstance(one, Answer):
            np.testing.assert_array_equal(other.stripe_share, one.stripe_share)
            np.testing.assert_array_equal(other.peak_ratio_median, one.peak_ratio_median)


def test_a_wall_that_the_solver_refuses_stops_no_other(rows, found, motions, monkeypatch):
    real = many_walls.collapses

    def refusing(wall, *arguments, **options):
        if np.any(np.asarray(wall.thickness) == 0.12):
            raise rd.InputError("a history would take too long")
        return real(wall, *arguments, **options)

    monkeypatch.setattr(many_walls, "collapses", refusing)
    for other, one in zip(answers(rows, motions, "PGV", 0.5), found, strict=True):
        if isinstance(one, Answer) and one.row.id != "d":
            np.testing.assert_array_equal(other.stripe_share, one.stripe_share)
        elif isinstance(one, Answer):
            assert other == BadRow(6, "d", "line 6: a history would take too long")


def test_the_table_has_a_row_for_each_damping_model_and_one_for_a_bad_row(found):
    table = [row for one in found for row in lines(one)]
    assert all(list(row) == list(COLUMNS) or set(row) == set(COLUMNS) for row in table)
    assert [row["id"] for row in table] == ["a", "a", "bad", "b", "b", "c", "c", "d", "d", "e", "e"]
    text = io.StringIO()
    csv.DictWriter(text, COLUMNS).writerows(table)
    assert "nan" not in text.getvalue()
    (bad,) = (row for row in table if row["error"])
    assert bad["error"].startswith("line 3: thickness is empty") and bad["collapses"] == ""
    first = table[0]
    assert (first["damping_model"], first["damping_ratio"], first["records"]) == ("CR", "", "14")
    assert float(first["median_intensity"]) == found[0].median[0]
    assert int(first["collapses"]) == found[0].collapses[0]


def test_where_half_of_the_records_collapse_a_wall_there_is_no_median_peak(rows, motions):
    strong = list(answers(rows[:1], motions, "PGV", 5.0))[0]
    assert strong.collapses.tolist() == [14, 14] and np.isnan(strong.peak_ratio_median).all()
    assert many_walls._median(np.array([0.1, 0.2, np.inf, np.inf])).item() != pytest.approx(0.2)
    assert many_walls._median(np.array([0.1, 0.2, 0.4, np.inf])).item() == pytest.approx(0.3)
    assert np.isnan(many_walls._median(np.array([0.1, 0.2, np.inf, np.inf])))


@pytest.mark.parametrize("measure", ["PGV", "PGA"])
def test_as_a_dataset_it_is_what_the_registry_says(found, measure, tmp_path):
    made = dataset(found, measure, 0.5)
    storage.write(made, tmp_path / "walls.nc", "batch", config={}, code_version="test")
    read = storage.open(tmp_path / "walls.nc")
    assert read["wall"].values.tolist() == ["a", "bad", "b", "c", "d", "e"]
    assert read["collapses"].sel(wall="bad").values.tolist() == [-1, -1]
    assert str(read["error"].sel(wall="bad").item()).startswith("line 3")
    assert float(read["dispersion"].sel(wall="e", damping_model="ECD16")) == found[-1].dispersion[1]


def test_every_wall_has_a_fragility_for_each_damping_model(found):
    functions = list(fragilities(found))
    assert [function.name for function in functions] == [f"{name}-{model}" for name in "abcde" for model in MODELS]
    assert functions[3].share == found[2].stripe_share[1].tolist()

"""A table of walls: what a row makes, that a bad one stops no other, and that each is what it is alone."""

import numpy as np
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp.assessment import assess
from rockdamp.assessment.answers import ANSWER_COLUMNS, tabulate_walls
from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.table import BadRow, read_walls
from rockdamp.storage import dataset

TABLE = """# walls of the school
id,thickness,height,overburden_ratio,parapet,a1,b1,a3,softening,preset,restitution,one_sided,diaphragm_period
a,0.25,3.0,0.5,,,,,,new,0.85,,
bad,,3.0,,,,,,,new,,,

b,0.2,1.2,,yes,,,,,severe,,,
c,0.30,4.5,1,,0.04,0.80,0.9,translated,,0.80,,
front,0.80,12,,yes,0.04,0.85,,,,0.5,yes,
floor,0.25,3.0,0.5,no,,,,,new,impulsive,,0.4s
"""


@pytest.fixture
def table(tmp_path):
    def written(text, encoding="utf-8"):
        path = tmp_path / "walls.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return written


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("walls") / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    return read_walls(path)


@pytest.fixture(scope="module")
def found(rows, motions):
    return assess_rows(rows, motions, "PGV", 0.5)


# --- reading ----------------------------------------------------------------------------------------------------------


def test_a_row_makes_what_it_states(rows):
    a, bad, b, c, front, floor = rows
    wall = rd.Wall(0.25, 3.0, overburden_ratio=0.5)
    assert (a.wall, a.curve, a.restitution) == (wall, rd.TrilinearCurve.preset("new"), 0.85)
    assert isinstance(bad, BadRow) and (bad.id, "thickness is empty" in bad.error) == ("bad", True)
    assert b.wall == rd.Parapet(0.2, 1.2) and b.restitution == float(b.wall.restitution_measured)
    assert c.curve == rd.TrilinearCurve(0.04, 0.80, 0.9, "translated")
    assert front.wall == rd.OneSidedWall(rd.Parapet(0.8, 12.0))
    assert (floor.diaphragm, floor.restitution) == (
        rd.Diaphragm(0.4),
        float(wall.restitution_impulsive),
    )


@pytest.mark.parametrize(
    ("head", "cells", "built"),
    [
        ("thickness [mm],height", "250,3", rd.Wall(0.25, 3.0)),
        ("thickness,height (ft)", "25cm,10", rd.Wall(0.25, 3.048)),
        (
            "thickness;height;density",
            "0.25;9ft 10.5in;18kN/m3",
            rd.Wall(0.25, 3.0099, density=18000 / 9.80665),
        ),
        ("thickness\theight\thinge_ratio", "0.25\t3\tweakest", rd.Wall(0.25, 3.0, hinge_ratio=0.7)),
        (
            "thickness,height,width,overburden [kN/m]",
            "0.25,3,2,12",
            rd.Wall(0.25, 3.0, width=2, overburden_ratio=24000 / (0.25 * 3 * 2 * 1800 * 9.80665)),
        ),
    ],
)
def test_numbers_have_their_unit_in_the_cell_or_in_the_head(head, cells, built, table):
    mark = next(mark for mark in ";\t," if mark in head)
    (row,) = read_walls(
        table(f"\ufeffid{mark}{head}{mark}preset\r\nwall no. 1{mark}{cells}{mark}new\r\n")
    )
    assert row.id == "wall no. 1"
    for name in ("thickness", "height", "weight", "overburden", "hinge_ratio"):
        assert float(getattr(row.wall, name)) == pytest.approx(
            float(getattr(built, name)), rel=1e-12
        )


@pytest.mark.parametrize(
    ("row", "named"),
    [
        ("x,25kg,3,,,,,,,new,,,", "thickness"),
        ("x,0.25,3,,,,,,,,,,", "preset"),
        ("x,0.25,3,,,0.1,,,,,,,", "b1"),
        ("x,0.25,3,,maybe,,,,,new,,,", "parapet"),
        ("x,0.25,3,,,,,,,new,high,,", "restitution"),
        ("x,0.25,3,,,,,,,new,1.2,,", "restitution"),
        ("x,nan,3,,,,,,,new,,,", "thickness"),
        ("x,0.25,3,,,,,,,newest,,,", "newest"),
        ("x,0.25,3,,,,,,,new,,yes,", "restitution"),
        ("x,0.25,3,,yes,,,,,new,0.5,yes,0.4", "diaphragm"),
        ('x,"0,25",3,,,,,,,new,,,', "the decimal sign must be a point"),
        ('x,"250,5mm",3,,,,,,,new,,,', "the decimal sign must be a point"),
    ],
)
def test_a_bad_row_says_why_and_stops_no_other(row, named, table):
    found = read_walls(table(f"{TABLE}{row}\nlast,0.25,3.0,,,,,,,new,,,\n"))
    assert found[-2].id == "x" and named in found[-2].error
    assert len(found) == 8 and found[-1].id == "last" and not isinstance(found[-1], BadRow)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "walls.csv"),
        ("id,thickness,height,preset\n", "rows"),
        ("id,thickness,preset\nx,0.3,new\n", "height"),
        ("id,thickness,height,presett\nx,0.3,3,new\n", "presett"),
        ("id,thickness,height,preset\nx,0.3,3,new\nx,0.3,3,new\n", "'x'"),
        ("id,thickness,height,preset\nx,0.3,3,new,0.85\n", "walls.csv"),
        ("id,thickness,height,preset\nx,0,3,3,new\n", "the decimal sign must be a point"),
    ],
)
def test_a_file_that_is_no_table_of_walls_is_refused(text, named, table):
    with pytest.raises(rd.InputError, match=named):
        read_walls(table(text))


# --- assessing --------------------------------------------------------------------------------------------------------


def test_each_wall_is_what_assess_says_of_it_alone(rows, found, motions):
    for row in rows:
        one = found.sel(wall=row.id)
        if isinstance(row, BadRow):
            assert one["row_error"].item() == row.error and np.isnan(one["dispersion"]).all()
            continue
        supports = rd.floor_motions(motions, diaphragm=row.diaphragm) if row.diaphragm else motions
        alone = rd.assess(row.wall, row.curve, supports, pgv=0.5, restitution=row.restitution)
        one = one.sel(damping_model=alone["damping_model"])
        assert not one["row_error"].item()
        for name in ("collapses", "peak_median"):
            np.testing.assert_array_equal(one[name], alone[name][:, 0])
        for name in (
            "rocking_onset",
            "damping_ratio",
            "stripe_collapses",
            "unconverged",
            "restitution",
            "records",
        ):
            np.testing.assert_array_equal(one[name], alone[name])
        for name in ("median_pgv", "dispersion", "median_uncertainty", "dispersion_uncertainty"):
            np.testing.assert_allclose(one[name], alone[name], rtol=1e-8)


def test_decimal_commas_between_semicolons_are_named(table):
    (row,) = read_walls(table("id;thickness [mm];height [m];preset\nw1;250;3,0;new\n"))
    assert row.error == "height is '3,0'; the decimal sign must be a point"


@pytest.mark.parametrize("tail", [-1.0, 1e6])
def test_a_rest_beyond_its_bounds_is_refused_once(tail, rows, motions):
    with pytest.raises(rd.InputError, match="tail"):
        assess_rows(rows, motions, "PGV", 0.5, tail=tail)


def test_how_many_run_at_once_changes_nothing(rows, found, motions):
    xr.testing.assert_identical(assess_rows(rows, motions, "PGV", 0.5, chunk=1), found)


def test_a_wall_that_cannot_be_run_stops_no_other(rows, found, motions, monkeypatch):
    real = assess.run_intensities

    def refusing(specimens, *arguments, **options):
        if np.any(np.asarray(getattr(specimens[0].wall, "thickness", 0)) == 0.30):
            raise rd.InputError("a history would take too long")
        return real(specimens, *arguments, **options)

    monkeypatch.setattr(assess, "run_intensities", refusing)
    other = assess_rows(rows, motions, "PGV", 0.5)
    assert other["row_error"].sel(wall="c").item() == "a history would take too long"
    assert (other["collapses"].sel(wall="c") == -1).all() and np.isnan(
        other["restitution"].sel(wall="c")
    )
    xr.testing.assert_identical(
        other.sel(wall=["a", "b", "front"]), found.sel(wall=["a", "b", "front"])
    )
    with pytest.raises(rd.InputError, match="thickness is empty"):
        assess_rows(rows[1:2], motions, "PGV", 0.5)


def test_a_building_a_floor_and_a_law_are_those_of_all_rows(rows, motions):
    few, building, floor = motions[:4], rd.Building(0.25, 3, 3), rd.Diaphragm(0.3)
    law = {"loss_exponent": 0.26, "reference_amplitude": 0.3}
    short = rows[0].__class__("short", rows[0].wall, rd.TrilinearCurve(0.02, 0.85, 0.2), 0.85)
    found = assess_rows(
        [*rows[:4], short], few, "PGA", 3.0, building=building, diaphragm=floor, **law
    )
    assert "reference_amplitude" in found["row_error"].sel(wall="short").item()
    for row in (rows[0], rows[2]):
        supports = rd.floor_motions(few, building, isinstance(row.wall, rd.Parapet), floor)
        alone = rd.assess(
            row.wall, row.curve, supports, pga=3.0, restitution=row.restitution, **law
        )
        np.testing.assert_array_equal(
            found["stripe_collapses"].sel(wall=row.id), alone["stripe_collapses"]
        )
    assert {row["loss_exponent"] for row in tabulate_walls(found) if not row["error"]} == {0.26}


def test_the_table_has_a_row_for_each_damper_and_one_for_a_bad_row(found):
    table = tabulate_walls(found)
    assert all(list(row) == list(ANSWER_COLUMNS) for row in table)
    names = [(row["id"], row["damping_model"]) for row in table]
    assert names[:4] == [("a", "CR"), ("a", "BAND"), ("bad", None), ("b", "CR")]
    assert [name for name in names if name[0] == "front"] == [("front", "CR")]
    assert "thickness is empty" in table[2]["error"] and table[2]["collapses"] is None
    assert (table[0]["damping_ratio"], table[0]["records"], table[0]["reason"]) == (None, 14, None)
    assert table[0]["median_intensity"] == found["median_pgv"].values[0, 0]


def test_a_row_without_a_fragility_says_why_by_its_own_counts(found):
    """Of two walls and two models one pair has collapses that become fewer; those of the others are separated."""
    made = found.sel(wall=["a", "b"]).copy(deep=True)
    first = np.arange(made.sizes["stripe"]) < 1
    made["stripe_collapses"][:] = np.where(first, 0, 14)
    made["stripe_collapses"].loc[{"wall": "a", "damping_model": "BAND"}] = np.where(first, 14, 0)
    reasons = {(row["id"], row["damping_model"]): row["reason"] for row in tabulate_walls(made)}
    assert [pair for pair, reason in reasons.items() if "not rise" in reason] == [("a", "BAND")]
    assert all(
        "none below it" in reason for pair, reason in reasons.items() if pair != ("a", "BAND")
    )


def test_as_datasets_they_are_what_the_glossary_says(found, answer, tmp_path):
    for kind, one in (("batch", found), ("assessment", answer)):
        dataset.write(one, tmp_path / "walls.nc", kind, config={}, code_version="test")
        read = dataset.read(tmp_path / "walls.nc")
        np.testing.assert_array_equal(read["dispersion"], one["dispersion"])
    assert read["station"].values.tolist() == answer["station"].values.tolist()

"""Tables of walls: what a row makes, and what is refused."""

import pytest
from wall_table import TABLE

import rockdamp as rd
from rockdamp.assessment.table import BadRow, read_walls

WALL = rd.Wall(0.25, 3.0, overburden_ratio=0.5)


@pytest.fixture
def table(tmp_path):
    def write(text):
        path = tmp_path / "walls.csv"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.fixture
def rows(table):
    return {row.id: row for row in read_walls(table(TABLE))}


def test_rows_keep_their_order(rows):
    assert list(rows) == ["a", "bad", "b", "c", "front", "floor"]


def test_a_row_with_a_preset(rows):
    row = rows["a"]
    assert row.wall == WALL
    assert row.curve == rd.TrilinearCurve.preset("new")
    assert row.restitution == 0.85


def test_an_empty_restitution_is_by_the_rule_measured(rows):
    row = rows["b"]
    assert row.wall == rd.Parapet(0.2, 1.2)
    assert row.restitution == float(row.wall.restitution_measured)


def test_a_row_with_a_curve_of_numbers(rows):
    assert rows["c"].curve == rd.TrilinearCurve(0.04, 0.80, 0.9, "translated")


def test_a_row_of_a_one_sided_wall(rows):
    assert rows["front"].wall == rd.OneSidedWall(rd.Parapet(0.8, 12.0))


def test_a_row_with_a_flexible_floor_and_a_rule(rows):
    assert rows["floor"].diaphragm == rd.Diaphragm(0.4)
    assert rows["floor"].restitution == float(WALL.restitution_impulsive)


def test_a_row_that_makes_no_wall(rows):
    assert isinstance(rows["bad"], BadRow)
    assert "thickness is empty" in rows["bad"].error


@pytest.mark.parametrize(
    ("head", "cells", "expected"),
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
    ids=["head", "feet", "semicolon", "tab", "overburden"],
)
def test_units_stand_in_the_cell_or_in_the_head(head, cells, expected, table):
    mark = next(mark for mark in ";\t," if mark in head)
    text = f"\ufeffid{mark}{head}{mark}preset\r\nwall no. 1{mark}{cells}{mark}new\r\n"
    (row,) = read_walls(table(text))
    assert row.id == "wall no. 1"
    for name in ("thickness", "height", "weight", "overburden", "hinge_ratio"):
        value = float(getattr(row.wall, name))
        assert value == pytest.approx(float(getattr(expected, name)), rel=1e-12)


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
        ("x,0.25,3,1e9,,,,,,new,,,", "overburden_ratio"),
        ("x,0.25,3,,,1e-9,0.8,,,,,,", "a1 is 1e-09"),
        ("x,0.25,3,,,,,,,new,,,1e9", "period"),
        ('x,"0,25",3,,,,,,,new,,,', "the decimal sign must be a point"),
        ('x,"250,5mm",3,,,,,,,new,,,', "the decimal sign must be a point"),
    ],
)
def test_a_bad_row_says_why_and_stops_no_other(row, named, table):
    rows = read_walls(table(f"{TABLE}{row}\nlast,0.25,3.0,,,,,,,new,,,\n"))
    assert len(rows) == 8
    assert rows[-2].id == "x"
    assert named in rows[-2].error
    assert rows[-1].id == "last"
    assert not isinstance(rows[-1], BadRow)


def test_decimal_commas_between_semicolons_are_named(table):
    (row,) = read_walls(table("id;thickness [mm];height [m];preset\nw1;250;3,0;new\n"))
    assert row.error == "height is '3,0'; the decimal sign must be a point"


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("", "walls.csv"),
        ("id,thickness,height,preset\n", "rows"),
        ("id,thickness,preset\nx,0.3,new\n", "height"),
        ("id,thickness,height,presett\nx,0.3,3,new\n", "presett"),
        ("id,thickness,height,preset\nx,0.3,3,new\nx,0.3,3,new\n", "'x'"),
        ("id,thickness,height,height,preset\nx,0.3,3,3,new\n", "height"),
        ("id,thickness,height,preset\nx,0.3,3,new,0.85\n", "walls.csv"),
        ("id,thickness,height,preset\nx,0,3,3,new\n", "the decimal sign must be a point"),
    ],
)
def test_a_file_that_is_no_table_of_walls_is_refused(text, named, table):
    with pytest.raises(rd.InputError, match=named):
        read_walls(table(text))

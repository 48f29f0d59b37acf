"""The table of walls: what a row makes, and that a bad one is told with its line and stops no other."""

import pytest

import rockdamp as rd
from rockdamp.assessment.table import BadRow, read_walls
from rockdamp.constants import PRESETS
from rockdamp.errors import InputError
from rockdamp.mechanics.wall import SORRENTINO_RATIO

TABLE = """id,thickness,height,overburden_ratio,hinge_ratio,parapet,a1,b1,a3,softening,preset,restitution
north,0.25,3.0,0.5,0.6,,0.04,0.85,0.95,translated,,0.85

south,0.25,3.0,,,no,,,,,new,
roof,0.2,1.2,,,yes,,,,,severe,
east,0.25,3.0,1,,,,,,,moderate,impulsive
"""


@pytest.fixture
def table(tmp_path):
    def written(text, encoding="utf-8"):
        path = tmp_path / "walls.csv"
        path.write_bytes(text.encode(encoding))
        return path

    return written


def test_a_row_makes_the_wall_the_curve_and_the_restitution_that_it_states(table):
    north, south, roof, east = read_walls(table(TABLE))
    assert [row.line for row in (north, south, roof, east)] == [2, 4, 5, 6]
    weakest = TABLE.replace(",0.6,", ",weakest,", 1)
    assert weakest != TABLE and float(read_walls(table(weakest))[0].wall.hinge_ratio) == pytest.approx(0.7)
    assert float(north.wall.weight) == float(rd.Wall(0.25, 3.0, overburden_ratio=0.5).weight)
    assert (float(north.wall.hinge_ratio), float(north.wall.overburden_ratio)) == (0.6, 0.5)
    curve = north.curve
    assert [float(curve.yield_displacement_ratio), float(curve.strength_ratio)] == [0.04, 0.85]
    assert (float(curve.ultimate_displacement_ratio), curve.softening) == (0.95, "translated")
    assert north.restitution == 0.85
    assert float(south.curve.strength_ratio) == PRESETS["new"][0]
    assert south.restitution == pytest.approx(SORRENTINO_RATIO * float(rd.Wall(0.25, 3.0).restitution_rigid))
    assert isinstance(roof.wall, rd.Parapet) and roof.restitution == float(rd.Parapet(0.2, 1.2).restitution_rigid)
    assert east.restitution == float(rd.Wall(0.25, 3.0, overburden_ratio=1).restitution_impulsive)


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("x,,3,,,,,,,,new,", "thickness is empty"),
        ("x,25kg,3,,,,,,,,new,", "thickness: '25kg' must be a number in m"),
        ("x,0.25,3,,,,,,,,,", "a1 is empty; there must be a1 and b1, or preset"),
        ("x,0.25,3,,,maybe,,,,,new,", "parapet is 'maybe'; it must be yes, no or empty"),
        ("x,0.25,3,,0.7,yes,,,,,new,", "hinge_ratio is 0.7; a parapet has no hinge"),
        ("x,0.25,3,,,,,,,,new,high", "restitution: 'high'"),
        ("x,0.25,3,,,,,,,,new,1.2", "is 1.2"),
        ("x,0.25,3,,,,,,,,new,0.8_5", "restitution: '0.8_5'"),
        ("x,0.25,3", "there are 3 cells; there must be 12"),
        (",0.25,3,,,,,,,,new,", "id is empty"),
        ("north,0.25,3,,,,,,,,new,", "id is 'north', as on line 2; each wall must have its own"),
    ],
)
def test_a_bad_row_is_told_with_its_line_and_stops_no_other(row, said, table):
    rows = read_walls(table(f"{TABLE}{row}\nlast,0.25,3.0,,,,,,,,new,\n"))
    (bad,) = (row for row in rows if isinstance(row, BadRow))
    assert bad.line == 7 and bad.error.startswith("line 7: ") and said in bad.error
    assert len(rows) == 6 and rows[-1].id == "last" and not isinstance(rows[-1], BadRow)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("id,thickness\n", "line 1: the column 'height' is missing; they must be id, thickness, height and any of"),
        ('id,thickness,height\nx,"0.25,3\n', "line 2: unexpected end of data; it must be a CSV"),
    ],
)
def test_a_file_that_is_no_table_of_walls_is_refused(text, said, table):
    with pytest.raises(InputError) as caught:
        read_walls(table(text))
    assert said in str(caught.value) and "walls.csv" in str(caught.value)


def test_a_spreadsheet_s_byte_order_mark_and_line_ends_do_no_harm(table):
    assert len(read_walls(table("\ufeff" + TABLE.replace("\n", "\r\n")))) == 4


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_spreadsheet_s_decimal_commas_and_units_in_its_cells_are_read(mark, table):
    text = "id;thickness;height;density;overburden;preset\nA;250mm;9ft 10.5in;18kN/m3;12.5kN/m;new\nB;0,25;3,2;;;new\n"
    first, second = read_walls(table(text.replace(";", mark)))
    assert [float(first.wall.thickness), float(first.wall.height)] == pytest.approx([0.25, 118.5 * 0.0254], rel=1e-12)
    assert float(first.wall.density) == pytest.approx(18000 / 9.80665, rel=1e-12)
    assert float(first.wall.overburden / first.wall.width) == pytest.approx(12500, rel=1e-12)
    assert (float(second.wall.thickness), float(second.wall.height)) == (0.25, 3.2)


def test_a_load_is_on_a_metre_and_stands_alone(table):
    head = "id,thickness,height,width,overburden [kN/m],overburden_ratio,preset\n"
    rows = read_walls(table(f"{head}a,0.25,3,2,12,,new\nb,0.25,3,2,12,1,new\nc,0.25,3,2,12kN,,new\n"))
    assert float(rows[0].wall.overburden) == pytest.approx(24000, rel=1e-12)
    assert "overburden and overburden_ratio state the same" in rows[1].error
    assert "overburden: '12kN'" in rows[2].error


def test_the_overburden_has_a_mass_where_its_column_says_so(table):
    head = "id,thickness,height,overburden_ratio,overburden_mass,parapet,restitution,preset\n"
    cells = ["a,0.3,4.5,2,1,,,new", "b,0.3,4.5,2,1,,impulsive,new", "c,0.3,0.7,,,,impulsive,new"]
    heavy, refused, stopped, parapet = read_walls(table("\n".join([head.strip(), *cells, "d,0.3,1,1,1,yes,,new"])))
    assert heavy.wall == rd.Wall(0.3, 4.5, overburden_ratio=2.0, overburden_mass=1.0)
    assert heavy.restitution == float(heavy.wall.restitution_measured)
    assert "is 'impulsive'; with overburden_mass it must be a number or another rule" in refused.error
    assert stopped.restitution == 0.0
    assert "overburden_mass is 1; nothing holds it on a parapet" in parapet.error


def test_remarks_capitals_and_columns_of_other_names_do_no_harm(table):
    head, *rest = TABLE.splitlines()
    lines = ["# walls of the school", f"{head.upper()},STOREY,restitutio", f"{rest[0]},2,1"]
    path = table("\n".join([*lines, "# the rest is of another house"]) + "\n")
    with pytest.warns(UserWarning, match="not read: STOREY, restitutio"):
        (row,) = read_walls(path)
    (north, *_) = read_walls(table(TABLE))
    assert (row.id, row.line, row.restitution) == ("north", 3, 0.85) and row.wall == north.wall


@pytest.mark.parametrize(
    ("suffix", "reader", "package"), [(".xlsx", "read_excel", "openpyxl"), (".parquet", "read_parquet", "pyarrow")]
)
def test_workbooks_are_read_by_pandas_or_must_be_saved(suffix, reader, package, tmp_path, monkeypatch):
    import pandas as pd

    path = tmp_path / f"walls{suffix}"
    with pytest.raises(FileNotFoundError):  # whatever is installed
        read_walls(path)
    path.write_bytes(b"")

    def missing(_):
        raise ImportError("Missing optional dependency")

    monkeypatch.setattr(pd, reader, missing)
    with pytest.raises(InputError, match=f"needs {package}; it must be saved as CSV, or: pip install {package}"):
        read_walls(path)
    frame = pd.DataFrame({"id": ["a"], "thickness": [0.25], "height": [3.0], "a1": [None], "preset": ["new"]})
    monkeypatch.setattr(pd, reader, lambda _: frame)
    (row,) = read_walls(path)
    assert (row.id, float(row.wall.thickness), row.line) == ("a", 0.25, 2)

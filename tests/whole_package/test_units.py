"""Numbers with units, lists and ranges: what is written comes back as it was meant, in every notation."""

from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

import rockdamp as rd
from rockdamp import units
from rockdamp.assessment.table import BadRow, read_walls
from rockdamp.vocabulary import STANDARD_GRAVITY

# The SI unit, and ways to write a unit of its kind with its size.
WRITTEN = {
    "m": {"m": "1", "mm": "0.001", " cm": "0.01", "in": "0.0254", "ft": "0.3048"},
    "s": {"s": "1", "ms": "0.001", " min": "60"},
    "m s-1": {"m/s": "1", "cm/s": "0.01", " m s-1": "1", "in/sec": "0.0254"},
    "m s-2": {"g": repr(STANDARD_GRAVITY), "m/s^2": "1", "cm/s/s": "0.01", " m s**-2": "1", "mm·s⁻²": "0.001"},
    "kg m-3": {"t/m^3": "1000", " kg m-3": "1", "g/cm3": "1000", "kg/(m^3)": "1"},
}
DIGITS = st.decimals(min_value=0, max_value=999, places=3)


def plain(value: Decimal) -> str:
    return f"{value:f}"


NOTATIONS = st.sampled_from(
    [
        plain,
        "{:e}".format,
        "{:E}".format,
        "{:+f}".format,
        lambda value: plain(value).lstrip("0") or "0",
        " {:f} ".format,
    ]
)


@st.composite
def lists(draw):
    """A list in some notation, its SI unit, and the numbers that it means."""
    wanted = draw(st.sampled_from(["", *WRITTEN]))
    values = draw(st.lists(DIGITS, min_size=1, max_size=5))
    texts = [draw(NOTATIONS)(value) for value in values]
    if not wanted:
        return ",".join(texts), wanted, [float(value) for value in values]
    how = draw(st.sampled_from(["none", "last", "each"]))
    stated = [draw(st.sampled_from(list(WRITTEN[wanted]))) for _ in values]
    if how != "each":
        stated = len(values) * [stated[-1]]
    sizes = [Decimal(1) if how == "none" else Decimal(WRITTEN[wanted][unit]) for unit in stated]
    with_unit = [text.rstrip() + unit for text, unit in zip(texts, stated, strict=True)]
    texts = {"none": texts, "last": [*texts[:-1], with_unit[-1]], "each": with_unit}[how]
    return ",".join(texts), wanted, [float(value * size) for value, size in zip(values, sizes, strict=True)]


@given(lists())
def test_a_list_in_any_notation_comes_back_as_it_was_meant(written):
    text, wanted, expected = written
    assert units.quantities(text, wanted) == expected
    if len(expected) == 1:
        assert units.quantity(text, wanted) == expected[0]


@given(st.integers(0, 900), st.integers(1, 50), st.integers(0, 20), st.sampled_from([0, -1, -3]), NOTATIONS)
def test_a_range_has_both_ends_and_no_noise(start, step, count, exponent, notation):
    numbers = [Decimal(start + index * step).scaleb(exponent) for index in range(count + 1)]
    text = ":".join(notation(value) for value in (numbers[0], numbers[-1], Decimal(step).scaleb(exponent)))
    assert units.quantities(text, "") == list(map(float, numbers))
    assert units.quantities(f"{text}cm/s", "m s-1") == [float(value / 100) for value in numbers]


@pytest.mark.parametrize(
    ("text", "wanted", "expected"),
    [
        ("0.2,4e-1", "m s-1", [0.2, 0.4]),
        ("0.1:0.5:2e-1", "m s-1", [0.1, 0.3, 0.5]),
        ("2,3e-1", "m s-2", [2, 0.3]),
        ("20,4e1cm/s", "m s-1", [0.2, 0.4]),
        ("0.2g:0.6g:0.2g", "m s-2", [1.96133, 3.92266, 5.88399]),
        ("0.1:0.3:0.1,0.9", "", [0.1, 0.2, 0.3, 0.9]),
        ("102mm", "m", [0.102]),
        ("112 lb/ft^3", "kg m-3", [112 * 0.45359237 / 0.3048**3]),
        ("12kN/m", "kg s-2", [12000]),
    ],
)
def test_what_is_written_is_read_as_it_stands(text, wanted, expected):
    assert units.quantities(text, wanted) == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("text", [*"0.8_5 ٣ 0,8_5 1e 0x10 nan inf 1e400 , 1, 1:2 2:1:1".split(), ""])
@pytest.mark.parametrize("wanted", ["", "m"])
def test_what_is_no_number_list_or_range_is_refused(text, wanted):
    with pytest.raises(units.UnitError):
        units.quantities(text, wanted)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("3kg", "'3kg' is in kg"),
        ("0.3 foo", "'0.3 foo' has an unknown unit, foo"),
        ("5mm²", "is in mm²"),
        ("1mm,2", "has a unit, but not at its last number"),
        ("0:1:0.0001", "has more than 1000 values"),
        ("0,85", "'0,85' has a comma after 0: a comma divides a list, and the decimal sign is a point"),
        ("0,85:0,95:0,01", "has a comma after 0"),
    ],
)
def test_an_error_says_what_is_wrong(text, said):
    with pytest.raises(units.UnitError, match=said):
        units.quantities(text, "m")


def _wall(path, text):
    path.write_text(f"id,thickness,height,preset\na,{text},9,new\n", encoding="utf-8")
    (row,) = read_walls(path)
    if isinstance(row, BadRow):
        raise rd.InputError(row.error)
    return row.wall.thickness


READERS = (_wall, lambda _, text: units.quantity(text, "m"))


@pytest.mark.filterwarnings("ignore::rockdamp.InputWarning")
@pytest.mark.parametrize("read", READERS)
def test_every_reader_takes_the_same_texts_for_numbers(read, tmp_path):
    path = tmp_path / "a.csv"
    for text in ("0.85", "8.5e-1", "85E-2", "+0.85"):
        assert read(path, text) == 0.85
    for text in ("0.8_5", "8_5", "0.\u0668\u0665", "\uff10.85"):
        with pytest.raises((rd.InputError, units.UnitError)):
            read(path, text)

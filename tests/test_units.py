"""Numbers with units, in every spelling of the table, and refusals of others."""

import pytest

from rockdamp import units

FOOT = 0.3048
POUND = 0.45359237
G = 9.80665


@pytest.mark.parametrize(
    ("text", "unit", "expected"),
    [
        ("0.85", "", 0.85),
        ("5%", "", 0.05),
        ("1e-3", "m", 0.001),
        ("102mm", "m", 0.102),
        ("-5 cm", "m", -0.05),
        ("4in", "m", 0.1016),
        ("13ft 6in", "m", 13.5 * FOOT),
        ("13' 6\"", "m", 13.5 * FOOT),
        ("500ms", "s", 0.5),
        ("2 sec", "s", 2.0),
        ("40 cm s-1", "m s-1", 0.4),
        ("0.3g", "m s-2", 0.3 * G),
        ("25%g", "m s-2", 0.25 * G),
        ("300 CM/SEC**2", "m s-2", 3.0),
        ("300cm/s^2", "m s-2", 3.0),
        ("3 m s-2", "m s-2", 3.0),
        ("1.8t/m^3", "kg m-3", 1800.0),
        ("18kN/m3", "kg m-3", 18000 / G),
        ("112 lb/ft3", "kg m-3", 112 * POUND / FOOT**3),
        ("12kN/m", "N m-1", 12000.0),
        ("800lb/ft", "N m-1", 800 * POUND * G / FOOT),
        ("30deg", "rad", 0.5235987755982988),
    ],
)
def test_number_with_its_unit_is_in_si(text, unit, expected):
    assert units.quantity(text, unit) == pytest.approx(expected, rel=1e-14)
    assert units.quantities(f"{text},{text}", unit) == 2 * [units.quantity(text, unit)]


@pytest.mark.parametrize(("text", "expected"), [("102mm", 0.102), ("0.7cm", 0.007)])
def test_conversion_leaves_no_noise(text, expected):
    assert units.quantity(text, "m") == expected


def test_si_unit_is_its_own_spelling():
    assert all(units.size(unit, unit) == 1 for unit in units.UNITS if unit)


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("4,5", "m"),
        ("3furlong", "m"),
        ("0.3g", "m"),
        ("2m", ""),
        ("nan", ""),
        ("1_0", ""),
        ("", "m"),
        ("4Hz", "s"),
    ],
)
def test_other_unit_or_no_number_is_refused_with_its_text(text, unit):
    with pytest.raises(ValueError, match=repr(text)):
        units.quantity(text, unit)


@pytest.mark.parametrize(("text", "unit"), [("4,5", "m"), ("3,0m", "m"), ("-0,25 g", "m s-2")])
def test_decimal_comma_is_named(text, unit):
    with pytest.raises(ValueError, match="the decimal sign must be a point"):
        units.quantity(text, unit)


def test_decimal_comma_is_named_in_a_list():
    with pytest.raises(ValueError, match="'0,85' has a decimal comma"):
        units.quantities("0,85")


@pytest.mark.parametrize("text", ["0.2,0.4g", "0,4g"])
def test_list_has_a_unit_at_each_number_or_at_none(text):
    with pytest.raises(ValueError, match="unit at each number"):
        units.quantities(text, "m s-2")


@pytest.mark.parametrize(
    ("head", "expected"),
    [("thickness [mm]", ("thickness", "mm")), ("time (s)", ("time", "s")), (" id ", ("id", ""))],
)
def test_head_of_a_column_has_a_name_and_a_unit(head, expected):
    assert units.name_and_unit(head) == expected

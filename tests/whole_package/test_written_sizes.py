"""Sizes and loads as people write them, against the definitions of their units."""

import pytest

from rockdamp.units import density, length, overburden, overburden_ratio
from rockdamp.vocabulary import STANDARD_GRAVITY

POUND, FOOT = 0.45359237, 0.3048  # [kg], [m]
FORCE = POUND * STANDARD_GRAVITY  # of a pound [N]


@pytest.mark.parametrize(("text", "feet"), [("13'", 13), ("13ft 6in", 13.5), ("13' 6\"", 13.5), ("8.5 ft", 8.5)])
def test_feet_and_inches_are_lengths(text, feet):
    assert length(text) == pytest.approx(feet * FOOT, rel=1e-12)


def test_a_weight_by_volume_is_a_density():
    for text in ("112pcf", "112 lb/ft3"):
        assert density(text) == pytest.approx(112 * POUND / FOOT**3, rel=1e-9)
    assert density("18kN/m3") == pytest.approx(18000 / STANDARD_GRAVITY)


@pytest.mark.parametrize(
    ("text", "load", "lengths"),
    [
        ("2kip/ft", 2000 * FORCE / FOOT, 1),
        ("250psf", 250 * FORCE / FOOT**2, 2),
        ("60kPa", 60e3, 2),
        ("12kN/m", 12e3, 1),
        ("12kN", 12e3, 0),
    ],
)
def test_a_load_is_on_the_whole_wall_per_metre_or_on_its_top(text, load, lengths):
    found = overburden(text)
    assert found == (pytest.approx(load, rel=1e-9), lengths)
    whole = load * 2.0 ** min(lengths, 1) * (0.25 if lengths == 2 else 1)  # 2 m wide, 0.25 m thick
    assert overburden_ratio(*found, weight=1000.0, width=2.0, thickness=0.25) == pytest.approx(whole / 1000)

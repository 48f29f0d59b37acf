"""Numbers and lists as people write them."""

import pytest

from rockdamp import text


@pytest.mark.parametrize(
    ("value", "digits", "expected"),
    [
        (0.0287654, 3, "0.0288"),
        (123.456, 2, "123"),
        (-0.5, 3, "−0.500"),
        (4.0, 3, "4"),
        (0, 3, "0"),
        (1.234e-5, 3, "1.23\u00a0×\u00a010⁻⁵"),
        (float("nan"), 3, "–"),
    ],
)
def test_number_has_significant_digits(value, digits, expected):
    assert text.number(value, digits) == expected


@pytest.mark.parametrize(
    ("value", "expected"),
    [(0.09456, "9.5\u00a0%"), (2e-5, "less than 0.01\u00a0%"), (float("nan"), "–")],
)
def test_fraction_is_a_percentage(value, expected):
    assert text.percent(value) == expected


def test_parameter_is_written_as_it_was_chosen():
    assert text.plain(0.5) == "0.5"


@pytest.mark.parametrize(
    ("words", "expected"), [([], ""), (["a"], "a"), (["a", "b", "c"], "a, b and c")]
)
def test_list_ends_with_and(words, expected):
    assert text.join_words(words) == expected


@pytest.mark.parametrize(("count", "expected"), [(1, "1 station"), (4, "4 stations")])
def test_noun_follows_its_count(count, expected):
    assert text.count_noun(count, "station") == expected

"""Numbers as people write them."""

from rockdamp import text


def test_numbers_read_as_people_write_them():
    assert text.number(0.0287654) == "0.0288"
    assert text.number(123.456, 2) == "123"
    assert text.number(-0.5) == "−0.500"
    assert text.number(4.0) == "4"
    assert text.number(0) == "0"
    assert text.number(1.234e-5) == "1.23\u00a0×\u00a010⁻⁵"
    assert text.number(float("nan")) == text.percent(float("nan")) == "–"
    assert text.percent(0.09456) == "9.5\u00a0%"
    assert text.percent(2e-5) == "less than 0.01\u00a0%"
    assert text.plain(0.5) == "0.5"


def test_lists_read_as_people_write_them():
    assert text.join_words([]) == ""
    assert text.join_words(["a"]) == "a"
    assert text.join_words(["a", "b", "c"]) == "a, b and c"

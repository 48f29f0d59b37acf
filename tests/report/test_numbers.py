"""Numbers as people write them."""

from rockdamp.report import numbers


def test_numbers_read_as_people_write_them():
    assert numbers.number(0.0287654) == "0.0288"
    assert numbers.number(123.456, 2) == "123"
    assert numbers.number(-0.5) == "−0.500"
    assert numbers.number(4.0) == "4"
    assert numbers.number(0) == "0"
    assert numbers.number(1.234e-5) == "1.23&nbsp;×&nbsp;10<sup>−5</sup>"
    assert numbers.number(float("nan")) == "not defined"
    assert numbers.percent(0.09456) == "9.5&nbsp;%"
    assert numbers.percent(2e-5) == "less than 0.01&nbsp;%"
    assert numbers.plain(0.5) == "0.5"
    assert numbers.listed(["a"]) == "a"
    assert numbers.listed(["a", "b", "c"]) == "a, b and c"
    assert numbers.ranges([0.8, 0.85, 0.9], [False, False, False]) == "none"

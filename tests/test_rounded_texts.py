"""The comparison of printed numbers notices what it should."""

import pytest
from rounded_texts import alike, assert_shipped, holds


def test_a_last_digit_may_turn_and_nothing_else():
    assert alike("xi 0.0517 of 12", "xi  0.0518 of 12")
    assert not alike("xi 0.0517", "xi 0.0519") and not alike("xi 0.0517", "mu 0.0517")
    assert not alike("1.2e-3", "1.2e-2") and alike("-1.20e-3;4,51", "-1.21e-3;4,52")
    assert not alike("1 2", "1 2 3") and not alike("0.05", "-0.05")
    assert holds("a\nxi 0.1\nmu 0.2\nb", "xi 0.1\nmu 0.3") and not holds(
        "xi 0.1\nb\nmu 0.2", "xi 0.1\nmu 0.2"
    )


def test_of_what_is_shipped_hardly_any_digit_turns():
    made = "\n".join(f"{k},0.{k:03d}" for k in range(200, 400))
    assert_shipped(made, made.replace("0.234", "0.235"))
    with pytest.raises(AssertionError):
        assert_shipped(made, made.replace("0.23", "0.24"))

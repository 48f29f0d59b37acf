"""Verdicts from the parts of a claim, and the words and numbers that go with them."""

import numpy as np
import pytest
import xarray as xr

from rockdamp.claims import verdicts
from rockdamp.claims.verdicts import CONDITIONAL, NOT_REPRODUCED, REPRODUCED, Part

# --- what is measured ------------------------------------------------------------------------------------------------


def test_numbers_have_three_digits_and_cases_are_runs():
    assert [verdicts.number(value) for value in (0.0123456, 12.3456, 5, 0.7)] == ["0.0123", "12.3", "5", "0.7"]
    assert verdicts.percent(0.07777) == "7.78%"
    held = xr.DataArray([True, True, False, True], coords={"restitution": [0.7, 0.71, 0.72, 0.73]})
    assert verdicts.spans(held, "e") == "e 0.7 to 0.71, 0.73"
    assert verdicts.spans(held & False, "e") == "none"
    assert verdicts.spans(held[:1], "e") == "e 0.7"


def test_where_there_is_no_case_nothing_holds():
    assert verdicts.judged(xr.DataArray(np.zeros(0, bool), dims="e"), (), "e") == Part(False)


def test_findings_have_two_digits_and_ranges_where_values_differ():
    assert [verdicts.brief(value) for value in (0.14312, 1.0, 0.0060849, -0.72, 0)] == [
        "14%",
        "100%",
        "0.61%",
        "-72%",
        "0%",
    ]
    assert verdicts.between(np.array([0.432, 0.371])) == "37% to 43%"
    assert verdicts.between(np.array([0.4, 0.4])) == "40%" and verdicts.between(np.array([])) == "none"


# --- verdicts from parts ---------------------------------------------------------------------------------------------


YES, NO, PARTLY = Part(True), Part(False), Part(False, where="e 0.7")


@pytest.mark.parametrize(
    ("needed", "parts", "verdict"),
    [
        (["a"], (YES, YES, YES), REPRODUCED),
        (["a"], (YES, NO, YES), CONDITIONAL),
        (["a"], (PARTLY, YES, YES), CONDITIONAL),
        (["a"], (NO, YES, YES), NOT_REPRODUCED),
        (["a", "b"], (YES, NO, YES), NOT_REPRODUCED),
        (["a", "b"], (YES, PARTLY, NO), CONDITIONAL),
        ({"count": 1, "of": ["a", "b"]}, (NO, YES, YES), CONDITIONAL),
        ({"count": 1, "of": ["a", "b"]}, (NO, NO, YES), NOT_REPRODUCED),
        ({"count": 2, "of": ["a", "b", "c"]}, (NO, YES, PARTLY), CONDITIONAL),
        ({"count": 2, "of": ["a", "b", "c"]}, (NO, YES, NO), NOT_REPRODUCED),
    ],
)
def test_parts_add_up_to_a_verdict(needed, parts, verdict):
    claim = {"parts": {"a": "A", "b": "B", "c": "C"}, "needed": needed}
    assert verdicts.combine(claim, dict(zip("abc", parts, strict=True)), capped=False) == verdict


def test_conditions_say_what_holds_what_holds_in_part_and_what_does_not():
    words = {"a": "A", "b": "B", "c": "C"}
    parts = verdicts.sorted_out({"parts": words}, {"a": YES, "b": PARTLY, "c": NO})
    text = dict.fromkeys(("id", "section", "claim", "threshold", "finding", "figure", "later"), "")
    verdict = verdicts.Verdict(**text, verdict=CONDITIONAL, measured=(), reasons=("because",), **parts)
    assert verdict.condition == "because; holds: A; holds in part: B (e 0.7); does not hold: C"

"""The data file of claims and the table of verdicts: what does not fit is refused where it stands."""

import copy
import json

import pytest
import xarray as xr
from made_up_claims import FILE, JUDGES, MEASURED

from rockdamp import claims
from rockdamp.claims.verdicts import CONDITIONAL, NOT_JUDGED, NOT_REPRODUCED, REPRODUCED
from rockdamp.errors import InputError
from rockdamp.figures import FIGURES

ONE = {"bilinear-demand": JUDGES["bilinear-demand"]}


def test_the_data_file_lists_every_claim_of_the_paper_and_each_has_a_judge(listed):
    assert {claim["id"] for claim in listed} == set(JUDGES) and len(JUDGES) == 29
    assert {claim["id"] for claim in claims.read(FILE)} == set(claims.JUDGES)
    assert {claim["id"] for claim in claims.read(MEASURED)} == set(claims.MEASURED) and len(claims.MEASURED) == 4


def test_a_claim_whose_dataset_is_left_out_is_not_judged_and_says_why(listed, data):
    del data["bilinear"]
    (verdict,) = claims.judge([claim for claim in listed if claim["id"] == "bilinear-demand"], data, ONE)
    assert (verdict.verdict, verdict.reasons) == (NOT_JUDGED, (claims.LEFT_OUT,))
    assert verdict.condition == claims.LEFT_OUT


def test_what_a_claim_needs_is_among_its_parts_and_what_holds_a_verdict_back_is_said(listed):
    for claim in listed:
        needed = claim["needed"] if isinstance(claim["needed"], list) else claim["needed"]["of"]
        assert needed and set(needed) <= set(claim["parts"])
        held_back = claim.get("inferred") or "validation" in claim["datasets"]
        assert bool(claim.get("condition")) >= bool(held_back), claim["id"]


def test_the_table_has_a_row_for_each_claim_and_the_columns_of_the_contract(listed, data):
    table = claims.table(claims.judge(listed, data, JUDGES))
    assert list(table.columns[:7]) == ["id", "section", "claim", "verdict", "measured", "threshold", "condition"]
    assert list(table.columns[7:]) == ["finding", "holds", "holds_in_part", "does_not_hold", "figure", "later"]
    assert list(table["id"]) == [claim["id"] for claim in listed]
    assert set(table["verdict"]) <= {REPRODUCED, CONDITIONAL, NOT_REPRODUCED, NOT_JUDGED}
    may_lack = ["condition", "figure", "holds", "holds_in_part", "does_not_hold", "later"]
    assert (table.drop(columns=may_lack) != "").all(axis=None)
    assert not table[["threshold", "finding"]].apply(lambda column: column.str.contains(r"[{}]")).any(axis=None)


def test_the_lists_of_parts_are_those_of_the_condition_and_hold_every_part_once(listed, data):
    for claim, verdict in zip(listed, claims.judge(listed, data, JUDGES), strict=True):
        if verdict.verdict == NOT_JUDGED:
            continue
        parts = [part.partition(" (")[0] for part in verdict.holds + verdict.holds_in_part + verdict.does_not_hold]
        assert sorted(parts) == sorted(words.partition(" (")[0] for words in claim["parts"].values())
        if verdict.verdict == CONDITIONAL and verdict.does_not_hold:
            assert f"does not hold: {', '.join(verdict.does_not_hold)}" in verdict.condition


def test_the_figures_that_claims_name_exist(listed):
    named = [claim["figure"] for claim in listed if "figure" in claim]
    assert len(named) > 20 and set(named) <= set(FIGURES)


def test_the_report_and_the_table_tell_the_same_of_each_claim(listed, data):
    verdicts = claims.judge(listed, data, JUDGES)
    told = json.loads(claims.as_json(verdicts))
    for verdict, (_, row) in zip(told, claims.table(verdicts).iterrows(), strict=True):
        assert {name: verdict[name] for name in ("id", "verdict", "finding")} == dict(row[["id", "verdict", "finding"]])
        for item in verdict["measured"]:
            assert item["quantity"] in row["measured"] and all(value in row["measured"] for value in item["values"])


def test_judging_leaves_the_datasets_as_they_were(listed, data, made_up):
    claims.judge(listed, data, JUDGES)
    for name, dataset in made_up.items():
        xr.testing.assert_identical(data[name], dataset)


def test_a_claim_without_a_judge_and_a_judge_without_a_claim_are_errors(listed, data):
    with pytest.raises(InputError, match="claim measured-restitution is judged, but not in the data file"):
        claims.judge(listed[:-1], data, JUDGES)
    with pytest.raises(InputError, match="claim new has no judge"):
        claims.judge([*listed, {**listed[0], "id": "new"}], data, JUDGES)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda c: c["limits"].pop("rise"), "limits has no 'rise'"),
        (lambda c: c["parts"].pop("impulsive"), "parts without words: impulsive"),
        (lambda c: c.update(finding="e is {printed}"), "finding has the gaps printed; they must be high, hinge, "),
    ],
)
def test_a_claim_that_its_judge_does_not_match_is_an_error(listed, data, change, message):
    changed = copy.deepcopy(listed)
    change(changed[0])
    with pytest.raises(InputError, match=f"claim ean-slender.*{message}"):
        claims.judge(changed, data, JUDGES)

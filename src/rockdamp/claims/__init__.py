"""Judge the paper's claims by the datasets: a verdict on each, with the numbers that it rests on.

The file data/claims.yaml holds the limits that decide. A function for each claim computes its quantities here.
"""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import asdict
from typing import Any

import pandas as pd

from rockdamp.claims import histories, mechanics, misfits, ratios
from rockdamp.claims import measured as measured_rocking
from rockdamp.claims.verdicts import (
    CONDITIONAL,
    NOT_JUDGED,
    Claim,
    Judge,
    Limits,
    Verdict,
    combine,
    finding_of,
    measured,
    sorted_out,
)
from rockdamp.errors import InputError
from rockdamp.storage import yaml_file
from rockdamp.storage.dataset import Datasets

COLUMNS = (
    *("id", "section", "claim", "verdict", "measured", "threshold", "condition"),
    *("finding", "holds", "holds_in_part", "does_not_hold", "figure", "later"),
)
MODULES = (mechanics, histories, ratios, misfits, measured_rocking)
JUDGES: dict[str, Judge] = {name: judge for module in MODULES for name, judge in module.JUDGES.items()}


def read(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read the data file of claims; its head says what the keys mean."""
    claims: list[dict[str, Any]] = yaml_file.read(path)["claims"]
    return claims


def judge(claims: Sequence[Claim], datasets: Datasets) -> list[Verdict]:
    """Return the verdict on each claim, in their order.

    `datasets` go by their names in the results, without suffix: ``damping_force``, ``match/amplitude``. A claim
    without a judge, a judge without a claim, a missing dataset, or limits and parts that the judge does not use raise
    `InputError`.
    """
    ids = [claim["id"] for claim in claims]
    for names, known, text in ((ids, JUDGES, "has no judge"), (JUDGES, ids, "is judged, but not in the data file")):
        for name in (name for name in names if name not in known):
            raise InputError(f"claim {name} {text}")
    return [judge_one(claim, datasets) for claim in claims]


def table(verdicts: Sequence[Verdict]) -> pd.DataFrame:
    """Return the verdicts as a table of text with the columns `COLUMNS`, lists joined by semicolons."""
    rows = [{name: getattr(verdict, name) for name in COLUMNS} for verdict in verdicts]
    joined = [
        {name: cell if isinstance(cell, str) else "; ".join(map(str, cell)) for name, cell in row.items()}
        for row in rows
    ]
    return pd.DataFrame(joined, columns=list(COLUMNS))


def as_json(verdicts: Sequence[Verdict]) -> str:
    """Return the verdicts with their lists, as the report reads them."""
    return json.dumps([asdict(verdict) for verdict in verdicts], ensure_ascii=False, indent=1) + "\n"


def judge_one(claim: Claim, datasets: Datasets) -> Verdict:
    """Return the verdict on one claim."""
    for name in claim["datasets"]:
        if name not in datasets:
            raise InputError(f"claim {claim['id']}: there is no dataset {name!r}")
    # A judge sees only the datasets that its claim names.
    data, limits = {name: datasets[name] for name in claim["datasets"]}, Limits(claim)
    judgements = JUDGES[claim["id"]](limits, data)
    for problem, names in (
        ("limits that decide nothing", set(limits) - limits.used),
        ("parts that are not judged", set(claim["parts"]) - set(judgements)),
        ("parts without words", set(judgements) - set(claim["parts"])),
    ):
        if names:
            raise InputError(f"claim {claim['id']} has {problem}: {', '.join(sorted(names))}")
    parts = {name: judgements[name] for name in claim["parts"]}
    synthetic = any(dataset.attrs.get("record_synthetic") == "yes" for dataset in data.values())
    missing = [str(item) for part in parts.values() if not part.testable for item in part.measured]
    capped = bool(claim.get("inferred"))
    ambiguous = bool(claim.get("ambiguous"))
    if ambiguous or synthetic or missing:  # a record that a model made tells of that model alone
        verdict, reasons = NOT_JUDGED, [claim["condition"]] * (ambiguous or synthetic) + missing
    else:
        verdict = combine(claim, parts, capped)
        reasons = [claim["condition"]] if capped and verdict == CONDITIONAL else []
    return Verdict(
        id=claim["id"],
        section=claim["section"],
        claim=claim["claim"],
        verdict=verdict,
        measured=sum((part.measured for part in parts.values()), ())
        + (measured("the records are synthetic") if synthetic else ()),
        threshold=claim["threshold"].format_map(claim["limits"]),
        reasons=tuple(reasons),
        finding=finding_of(claim, parts),
        # What cannot be judged has parts that neither hold nor fail.
        **sorted_out(claim, {} if verdict == NOT_JUDGED else parts),
        figure=claim.get("figure", ""),
        later=claim.get("later", ""),
    )


__all__ = ["COLUMNS", "JUDGES", "as_json", "judge", "judge_one", "read", "table"]

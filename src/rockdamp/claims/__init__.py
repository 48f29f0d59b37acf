"""Judge the paper's claims by the datasets: a verdict on each, with the numbers that it rests on.

The file data/claims.yaml holds the limits that decide. A function for each claim computes its quantities here.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from rockdamp.claims import measured as measured_rocking
from rockdamp.claims import mechanics, ratios
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
from rockdamp.storage.dataset import Datasets

COLUMNS = (
    *("id", "section", "claim", "verdict", "measured", "threshold", "condition"),
    *("finding", "holds", "holds_in_part", "does_not_hold", "figure", "later"),
)
MODULES = (mechanics, ratios)
JUDGES: dict[str, Judge] = {name: judge for module in MODULES for name, judge in module.JUDGES.items()}
MEASURED: dict[str, Judge] = measured_rocking.JUDGES  # what measured trials say, counted apart from the paper's claims
LEFT_OUT = "its study is left out of this config"


def read(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read the data file of claims; its head says what the keys mean."""
    claims: list[dict[str, Any]] = yaml.safe_load(Path(path).read_text(encoding="utf-8"))["claims"]
    return claims


def judge(claims: Sequence[Claim], datasets: Datasets, judges: Mapping[str, Judge] = JUDGES) -> list[Verdict]:
    """Return the verdict on each claim, in their order.

    `datasets` go by their names in the results, without suffix: ``damping_force``, ``match/amplitude``. A claim whose
    datasets are not all there is not judged. A claim without a judge, a judge without a claim, or
    limits and parts that the judge does not use raise `InputError`.
    """
    ids = [claim["id"] for claim in claims]
    for names, known, text in ((ids, judges, "has no judge"), (judges, ids, "is judged, but not in the data file")):
        for name in (name for name in names if name not in known):
            raise InputError(f"claim {name} {text}")
    return [
        judge_one(claim, datasets, judges) if set(claim["datasets"]) <= set(datasets) else _not_judged(claim)
        for claim in claims
    ]


def _not_judged(claim: Claim) -> Verdict:
    said = {"threshold": claim["threshold"].format_map(claim["limits"]), "reasons": (LEFT_OUT,), "finding": ""}
    empty: dict[str, Any] = dict.fromkeys(("measured", "holds", "holds_in_part", "does_not_hold"), ())
    names = ("id", "section", "claim")
    texts = {name: claim.get(name, "") for name in (*names, "figure", "later")}
    return Verdict(verdict=NOT_JUDGED, **texts, **said, **empty)


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


def judge_one(claim: Claim, datasets: Datasets, judges: Mapping[str, Judge] = JUDGES) -> Verdict:
    """Return the verdict on one claim, whose datasets are there."""
    # A judge sees only the datasets that its claim names.
    data, limits = {name: datasets[name] for name in claim["datasets"]}, Limits(claim)
    judgements = judges[claim["id"]](limits, data)
    for problem, names in (
        ("limits that decide nothing", set(limits) - limits.used),
        ("parts that are not judged", set(claim["parts"]) - set(judgements)),
        ("parts without words", set(judgements) - set(claim["parts"])),
    ):
        if names:
            raise InputError(f"claim {claim['id']} has {problem}: {', '.join(sorted(names))}")
    parts = {name: judgements[name] for name in claim["parts"]}
    synthetic = any(dataset.attrs.get("record_synthetic") == "yes" for dataset in data.values())
    capped = bool(claim.get("inferred"))
    if synthetic:  # a record that a model made tells of that model alone
        verdict, reasons = NOT_JUDGED, [claim["condition"]]
    else:
        verdict = combine(claim, parts, capped)
        reasons = [claim["condition"]] if capped and verdict == CONDITIONAL else []
    return Verdict(
        id=claim["id"],
        section=claim["section"],
        claim=claim["claim"],
        verdict=verdict,
        measured=sum((part.measured for part in parts.values()), ())
        + (measured("the record is synthetic") if synthetic else ()),
        threshold=claim["threshold"].format_map(claim["limits"]),
        reasons=tuple(reasons),
        finding=finding_of(claim, parts),
        # What cannot be judged has parts that neither hold nor fail.
        **sorted_out(claim, {} if verdict == NOT_JUDGED else parts),
        figure=claim.get("figure", ""),
        later=claim.get("later", ""),
    )


__all__ = ["COLUMNS", "JUDGES", "LEFT_OUT", "MEASURED", "as_json", "judge", "judge_one", "read"]
__all__ += ["table"]

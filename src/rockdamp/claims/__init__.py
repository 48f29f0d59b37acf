"""Judge the paper's claims by the datasets: for each a verdict, the numbers that decide, and one sentence.

data/claims.yaml has the claims in our words, with their limits. A function for each returns its parts, which hold or do
not, the numbers, and the sentence.
"""

from __future__ import annotations

import os
from typing import Any

import pandas as pd
import yaml

from rockdamp.claims import decays, ratios
from rockdamp.storage.dataset import Datasets
from rockdamp.text import join_words

HOLDS, IN_PART, FAILS, UNTESTED = "holds", "holds in part", "does not hold", "cannot be tested here"
COLUMNS = ["id", "section", "claim", "verdict", "measured", "threshold", "finding"]
JUDGES = {
    judge.__name__.replace("_", "-"): judge
    for judge in (
        *(decays.hinge_mass, decays.bilinear_demand, decays.ean_slender, decays.e_measured),
        *(decays.fig3_energy, decays.fig3_impact, decays.fig4_rigid, decays.fig4_smooth),
        *(ratios.amp_cdc, ratios.amp_cdr, ratios.amp_sign, ratios.amp_dispersion),
        *(ratios.slenderness, ratios.overburden, ratios.a1_most, ratios.a1_rank, ratios.a1_sign),
        *(ratios.err_secant, ratios.err_range, ratios.err_e),
        *(ratios.fit_order, decays.fig8_sdr, ratios.low_amp, ratios.best_cdr, ratios.good_sdr),
    )
}


def read(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read the claims; the head of data/claims.yaml says what the keys mean."""
    with open(path, encoding="utf-8") as file:
        claims: list[dict[str, Any]] = yaml.safe_load(file)["claims"]
    return claims


def judge(claim: dict[str, Any], datasets: Datasets) -> dict[str, str]:
    """Return the row of one claim in claims.csv. `datasets` go by their names in the results: ``match/amplitude``."""
    limits = claim.get("limits", {})
    parts, measured, finding = JUDGES[claim["id"]](datasets, limits)
    verdict = HOLDS if all(parts.values()) else IN_PART if any(parts.values()) else FAILS
    # A record that a model made, or a value that was chosen so that the claim holds, decides nothing.
    synthetic = (
        claim["id"] == "fig8-sdr" and datasets["validation"].attrs.get("record_synthetic") == "yes"
    )
    if synthetic or claim.get("inferred"):
        verdict = UNTESTED
    elif verdict == IN_PART:
        failed = join_words(part for part, holds in parts.items() if not holds)
        finding += f" Holds: {join_words(part for part, holds in parts.items() if holds)}. Does not hold: {failed}."
    threshold = claim["threshold"].format_map(limits)
    found = {"verdict": verdict, "measured": measured, "threshold": threshold, "finding": finding}
    return {name: (claim | found)[name] for name in COLUMNS}


def table(claims: list[dict[str, Any]], datasets: Datasets) -> pd.DataFrame:
    """Return the rows of all claims, in their order."""
    return pd.DataFrame([judge(claim, datasets) for claim in claims], columns=COLUMNS)

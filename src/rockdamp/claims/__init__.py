"""Judge the paper's claims by the datasets: a verdict, the numbers that decide, and one sentence.

data/claims.yaml states the claims in our words, with their limits. One function per claim returns
its parts, which hold or do not, the numbers and the sentence.
"""

from __future__ import annotations

import os
from typing import Any

import pandas as pd
import yaml

from rockdamp.claims import decays, match_errors, ratios, walls
from rockdamp.claims.judgement import Judgement, Untestable
from rockdamp.storage.dataset import Datasets
from rockdamp.text import DASH, join_words

HOLDS = "holds"
IN_PART = "holds in part"
FAILS = "does not hold"
UNTESTED = "cannot be tested here"
CLAIM_COLUMNS = ["id", "section", "claim", "verdict", "measured", "threshold", "finding"]
JUDGES = {
    "hinge-mass": walls.hinge_mass,
    "uncracked-capacity": walls.uncracked_capacity,
    "bilinear-demand": walls.bilinear_demand,
    "ean-slender": walls.ean_slender,
    "e-measured": walls.e_measured,
    "fig3-energy": decays.fig3_energy,
    "fig3-impact": decays.fig3_impact,
    "fig4-rigid": decays.fig4_rigid,
    "fig4-smooth": decays.fig4_smooth,
    "amp-cdc": ratios.amp_cdc,
    "amp-cdr": ratios.amp_cdr,
    "amp-sign": ratios.amp_sign,
    "amp-dispersion": ratios.amp_dispersion,
    "sdr-collapse": walls.sdr_collapse,
    "cdc-poor": match_errors.cdc_poor,
    "slenderness": ratios.slenderness,
    "overburden": ratios.overburden,
    "a1-most": ratios.a1_most,
    "a1-rank": ratios.a1_rank,
    "a1-sign": ratios.a1_sign,
    "a1-low-e": ratios.a1_low_e,
    "err-secant": match_errors.err_secant,
    "err-range": match_errors.err_range,
    "err-e": match_errors.err_e,
    "fit-order": ratios.fit_order,
    "fig8-sdr": decays.fig8_sdr,
    "fig8-peaks": decays.fig8_peaks,
    "low-amp": ratios.low_amp,
    "best-cdr": match_errors.best_cdr,
    "good-sdr": match_errors.good_sdr,
}


def read(path: str | os.PathLike[str]) -> list[dict[str, Any]]:
    """Read the claims; the head of data/claims.yaml explains the keys."""
    with open(path, encoding="utf-8") as file:
        claims: list[dict[str, Any]] = yaml.safe_load(file)["claims"]
    return claims


def judge(claim: dict[str, Any], datasets: Datasets) -> dict[str, str]:
    """Return the row of one claim in claims.csv.

    Parameters
    ----------
    claim : dict
        An entry of data/claims.yaml.
    datasets : mapping of str to xarray.Dataset
        The datasets of the results by name: ``match/amplitude``.
    """
    limits = claim.get("limits", {})
    reason = untested_reason(claim, datasets)
    try:
        judgement = JUDGES[claim["id"]](datasets, limits)
    except Untestable as error:
        judgement = Judgement({}, DASH, "")
        reason = str(error)
    verdict, words = (UNTESTED, reason) if reason else give_verdict(judgement.parts)
    if "history" in claim:
        words += f" History of the criterion: {claim['history']}."
    return {
        "id": claim["id"],
        "section": claim["section"],
        "claim": claim["claim"],
        "verdict": verdict,
        "measured": judgement.numbers,
        "threshold": claim["threshold"].format_map(limits),
        "finding": f"{judgement.finding} {words.strip()}".strip(),
    }


def untested_reason(claim: dict[str, Any], datasets: Datasets) -> str:
    """Return why a claim cannot be tested with these datasets, or an empty text if it can."""
    is_synthetic = datasets["validation"].attrs.get("record_synthetic") == "yes"
    if claim.get("needs_measured_record") and is_synthetic:
        return "This record is synthetic; the laboratory's record is not public."
    return claim.get("untested", "")


def give_verdict(parts: dict[str, bool]) -> tuple[str, str]:
    """Return the verdict, and the sentences that name the parts if only some of them hold."""
    holding = [part for part, holds in parts.items() if holds]
    failing = [part for part, holds in parts.items() if not holds]
    if not failing:
        return HOLDS, ""
    if not holding:
        return FAILS, ""
    return IN_PART, f"Holds: {join_words(holding)}. Does not hold: {join_words(failing)}."


def table(claims: list[dict[str, Any]], datasets: Datasets) -> pd.DataFrame:
    """Return the rows of all claims, in their order."""
    return pd.DataFrame([judge(claim, datasets) for claim in claims], columns=CLAIM_COLUMNS)

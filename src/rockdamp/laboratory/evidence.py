"""Evidence of a model: the likelihood of a record averaged over the prior."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.laboratory.least_squares import Fit
from rockdamp.laboratory.prior import Prior
from rockdamp.laboratory.problem import Problem

EFFECTIVE = 300.0  # draws, at least: the logarithm of the evidence is then known to 0.06


@dataclass(frozen=True)
class Evidence:
    """The logarithm of the evidence and its standard error; NaN, with the reason, where it could not be determined."""

    logarithm: float = np.nan
    standard_error: float = np.nan
    reason: str = ""


def evidence_of(fit: Fit | Sequence[Fit], prior: Prior, seed: int, *, loss_by_run: bool = False) -> Evidence:
    """Return the evidence of a model by one run or several; undetermined where its posterior is refused."""
    try:
        solutions = [one.solution() for one in ([fit] if isinstance(fit, Fit) else fit)]
        _, drawn = Problem.about(solutions, prior, loss_by_run=loss_by_run).drawn(EFFECTIVE, seed)
    except InputError as error:
        return Evidence(reason=str(error))
    return Evidence(drawn.log_evidence, drawn.error)


def probabilities(log_evidence: Array) -> Array:
    """Return the probability of each model, along the last axis, of those that were determined; all equal before."""
    known = np.isfinite(log_evidence)
    highest = np.max(np.where(known, log_evidence, -np.inf), axis=-1, keepdims=True)
    relative = np.exp(np.where(known, log_evidence - np.where(np.isfinite(highest), highest, 0.0), -np.inf))
    total = relative.sum(axis=-1, keepdims=True)
    return np.where(known, relative / np.where(total > 0, total, 1.0), np.nan)

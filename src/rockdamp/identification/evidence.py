"""How well each model explains a record: the evidence, the likelihood averaged over the prior."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.identification.importance import Evidence, Weighted, explore
from rockdamp.identification.least_squares import Fit
from rockdamp.identification.prior import Prior
from rockdamp.identification.problem import Problem

CHECKED, CHECKED_SEED = 32, 0  # draws at which the response to the noise of the motion must be linear
UNDETERMINED = Evidence(np.nan, np.nan, np.nan)


def weighted_draws(problem: Problem, random: np.random.RandomState) -> Weighted:
    """Draw from the posterior of a problem.

    Raises
    ------
    InputError
        If the response to the noise of the motion is not linear there.
    """
    found = explore(problem, random)
    problem.require_linear(found.resampled(CHECKED, np.random.RandomState(CHECKED_SEED)))
    return found


def evidence_of(fit: Fit, prior: Prior, seed: int) -> Evidence:
    """Return the evidence of a model; NaN where its posterior is not found, or its weights are not to be relied on."""
    try:
        found = weighted_draws(Problem.of(fit, prior), np.random.RandomState(seed))
    except InputError:
        return UNDETERMINED
    return found.evidence if found.good else replace(UNDETERMINED, k_hat=found.evidence.k_hat)


def probabilities(log_evidence: Array) -> Array:
    """Return the probability of each model, along the last axis, of those that were determined; all equal before."""
    known = np.isfinite(log_evidence)
    highest = np.max(np.where(known, log_evidence, -np.inf), axis=-1, keepdims=True)
    relative = np.exp(np.where(known, log_evidence - np.where(np.isfinite(highest), highest, 0.0), -np.inf))
    total = relative.sum(axis=-1, keepdims=True)
    return np.where(known, relative / np.where(total > 0, total, 1.0), np.nan)

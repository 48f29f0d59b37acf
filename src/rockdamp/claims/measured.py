"""Judge what measured free rocking of blocks says of the paper's dampers: ratios of velocity, no synthetic record."""

from __future__ import annotations

import numpy as np
import xarray as xr
from scipy.stats import chi2

from rockdamp.claims.verdicts import Limits, Part, by_id, judged, measured, number
from rockdamp.constants import PAPER_MODELS, REFERENCE
from rockdamp.storage.dataset import Datasets

NOUN = "impacts used"


def _likelihood(data: Datasets) -> xr.DataArray:
    """Return the log-likelihood of the paper's dampers."""
    return data["measured_rocking"]["log_likelihood"].sel(damping_model=list(PAPER_MODELS))


def _by_impacts(values: xr.DataArray) -> tuple[str, ...]:
    """Return a value for each number of impacts, in words."""
    return tuple(
        f"{number(value)} with {int(count)} impacts"
        for count, value in zip(values["impacts_used"].values, values.values, strict=True)
    )


def _ends(values: xr.DataArray) -> str:
    low, high = number(values.min()), number(values.max())
    return low if low == high else f"{low} to {high}"


def measured_cdr(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the likelihood of CDR with the larger of the others'."""
    likelihood = _likelihood(data)
    others = likelihood.drop_sel(damping_model="CDR")
    lead = likelihood.sel(damping_model="CDR", drop=True) - others.max("damping_model")
    best = str(likelihood.sum("impacts_used").idxmax("damping_model").item())
    parts = {
        "best": judged(
            lead > 0,
            measured("ln L of CDR less the larger of CDC's and SDR's", *_by_impacts(lead)),
            NOUN,
            limits["enough"],
            {"lead": _ends(lead), "best": best},
        ),
        "close": judged(lead > -limits["odds"], (), NOUN, limits["enough"]),
    }
    return parts


def measured_sdr(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the likelihood of SDR with the largest of the three."""
    likelihood = _likelihood(data)
    behind = likelihood.max("damping_model") - likelihood.sel(damping_model="SDR", drop=True)
    quantity = measured("the largest ln L of the three less SDR's", *_by_impacts(behind))
    place = (
        f"{_ends(behind)} below the largest of the three"
        if (behind > 0).any()
        else "the largest of the three throughout"
    )
    return {"good": judged(behind < limits["odds"], quantity, NOUN, limits["enough"], {"place": place})}


def measured_cdc(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Compare the likelihoods of CDR and SDR with CDC's."""
    likelihood, parts = _likelihood(data), {}
    for model in ("CDR", "SDR"):
        lead = likelihood.sel(damping_model=model, drop=True) - likelihood.sel(damping_model="CDC", drop=True)
        parts[model.lower()] = judged(
            lead > limits["odds"],
            measured(f"ln L of {model} less CDC's", *_by_impacts(lead)),
            NOUN,
            limits["enough"],
            {model.lower(): _ends(lead)},
        )
    return parts


def measured_restitution(limits: Limits, data: Datasets) -> dict[str, Part]:
    """Test one e for all impacts against the power law, of which it is the exponent 0, and see its exponent."""
    rocking = data["measured_rocking"]
    of_law, of_one_e = (rocking["log_likelihood"].sel(damping_model=model) for model in ("power law", REFERENCE))
    lower, upper = (rocking["amplitude_exponent_interval"].sel(bound=bound) for bound in ("lower", "upper"))
    exponent = rocking["amplitude_exponent"]
    p = xr.apply_ufunc(chi2.sf, 2 * (of_law - of_one_e), 1)
    quantity = measured("p of the likelihood ratio of the best power law to one e", *_by_impacts(p))
    return {
        "ratio": judged(p >= limits["level"], quantity, NOUN, limits["enough"], {"p": _ends(p)}),
        "interval": judged(
            (lower <= 0) & (upper >= 0),
            measured("exponent of the energy left", *_by_impacts(exponent)),
            NOUN,
            limits["enough"],
            {"exponent": f"{number(np.min(exponent))} to {number(np.max(exponent))}"},
        ),
    }


JUDGES = by_id(measured_cdr, measured_sdr, measured_cdc, measured_restitution)

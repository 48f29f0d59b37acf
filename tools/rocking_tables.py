"""Tables of docs/measured.md: what measured free rocking says of dampers and restitution."""

import xarray as xr
from scipy.stats import chi2
from table_text import models, table

from rockdamp.constants import REFERENCE

Data = dict[str, xr.Dataset]


def rocking(data: Data) -> str:
    """How far each damper's likelihood is below the best; one e against the power law; the amplitude's exponent."""
    study = data["measured_rocking"]
    behind = study["log_likelihood"].max("damping_model") - study["log_likelihood"]
    counts = [int(count) for count in study["impacts_used"].values]
    head = ["", *(f"{count} impacts" for count in counts)]
    names = list(map(str, study["damping_model"].values))
    rows = [[name, *(f"{float(value):.1f}" for value in behind.sel(damping_model=name))] for name in names]
    exponents = [_with_bounds(one, "amplitude_exponent") for one in (study.sel(impacts_used=n) for n in counts)]
    rows.append(["exponent of the energy left", *exponents])
    of_law, of_one_e = (study["log_likelihood"].sel(damping_model=model) for model in ("power law", REFERENCE))
    twice = 2 * (of_law - of_one_e)
    ratios = [f"{float(value):.1f} ({chi2.sf(float(value), 1):.2g})" for value in twice]
    rows.insert(-1, ["2 ln L of the power law over one e (p)", *ratios])
    return table(head, rows)


def _with_bounds(one: xr.Dataset, name: str) -> str:
    low, high = (f"{float(one[f'{name}_interval'].sel(bound=bound)):.2f}" for bound in ("lower", "upper"))
    return f"{float(one[name]):.2f} ({low} to {high})"


def rocking_restitution(data: Data) -> str:
    """Restitution over Housner's, and its spread."""
    study = data["measured_rocking"]
    rows = [
        ["mean of e over Housner's", f"{float(study['restitution_over_housner_mean']):.3f}"],
        ["deviation of ln e from trial to trial, mean over H/B", f"{float(study['deviation_within']):.3f}"],
        ["deviation of ln e from block to block, mean over H/B", f"{float(study['deviation_between']):.3f}"],
        [
            "first ratios over Housner's: deviation from trial to trial",
            f"{float(study['first_ratio_deviation_within']):.3f}",
        ],
        ["noise of one ratio in it: deviation in the median trial", f"{float(study['noise']):.3f}"],
        ["odd and even impacts that differ: deviation", f"{float(study['alternation']):.3f}"],
    ]
    return table(("", ""), rows)


def rocking_blocks(data: Data) -> str:
    """Restitution over Housner's and the spread of a trial's ln e, by slenderness."""
    head = ("H/B", "trials", "e over Housner's, 90 %", "deviation of ln e of a trial")
    rows = []
    for slenderness, one in models(data["measured_rocking"], "geometry"):
        low, high = (f"{float(bound):.3f}" for bound in one["restitution_over_housner_interval"])
        e, deviation = (f"{float(one[name]):.3f}" for name in ("restitution_over_housner", "trial_deviation"))
        rows.append([f"{float(slenderness):g}", str(int(one["geometry_trials"])), f"{e} ({low} to {high})", deviation])
    return table(head, rows)

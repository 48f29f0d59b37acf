"""Tables of docs/measured.md: what measured free rocking says of dampers and restitution."""

import xarray as xr
from scipy.stats import chi2
from table_text import models, percent, table

from rockdamp.constants import PAPER_MODELS, REFERENCE

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
    law = study["log_likelihood"].max("damping_model") - study["law_log_likelihood"]
    rows.insert(-1, ["the law of loss, g fitted", *(f"{round(float(value), 1) + 0.0:.1f}" for value in law)])
    of_law, of_one_e = (study["log_likelihood"].sel(damping_model=model) for model in ("power law", REFERENCE))
    twice = 2 * (of_law - of_one_e)
    ratios = [f"{float(value):.1f} ({chi2.sf(float(value), 1):.2g})" for value in twice]
    rows.insert(-1, ["2 ln L of the power law over one e (p)", *ratios])
    rows.append(["g of the law", *(f"{float(value):.2f}" for value in study["loss_exponent"])])
    rows.append(["trials with more impacts than the law allows", *map(percent, study["share_beyond_stop"])])
    measured, allowed = (float(study[f"{of}_impacts"].median()) for of in ("measured", "allowed"))
    return (
        f"{table(head, rows)}\n\nBy the first {int(study['shown_impacts'])} impacts the law allows {allowed:.0f} in the"
        f" median trial before the block stops; {measured:.0f} were measured."
    )


def _with_bounds(one: xr.Dataset, name: str) -> str:
    low, high = (f"{float(one[f'{name}_interval'].sel(bound=bound)):.2f}" for bound in ("lower", "upper"))
    return f"{float(one[name]):.2f} ({low} to {high})"


def rocking_curves(data: Data) -> str:
    """How much the likelihoods of the paper's dampers depend on the curve, and on the release that is not known."""
    study = data["measured_rocking"]
    best = float(study["log_likelihood"].sel(impacts_used=int(study["shown_impacts"])).max())
    parts = (("log_likelihood_by_curve", "yield_displacement_ratio", "a1"),)
    parts += (("log_likelihood_by_release", "release_amplitude", "u0/u_ins"),)
    head, rows = ["ln L below the best"], [[name] for name in PAPER_MODELS]
    for variable, dim, symbol in parts:
        head += [f"{symbol} = {value:g}" for value in study[dim].values.tolist()]
        for row in rows:
            row += [f"{best - float(value):.1f}" for value in study[variable].sel(viscous_model=row[0])]
    return table(head, rows)


def rocking_errors(data: Data) -> str:
    """What each part of the error model brings, and what it does to the exponent."""
    study = data["measured_rocking"]
    first = float(study["error_log_likelihood"][0])
    rows = [
        [name, f"{float(one['error_log_likelihood']) - first:.1f}", f"{float(one['error_amplitude_exponent']):.2f}"]
        for name, one in models(study, "error_model")
    ]
    return table(("error", "ln L", "exponent"), rows)


def rocking_restitution(data: Data) -> str:
    """Restitution over Housner's, its spread, and how well it predicts."""
    study = data["measured_rocking"]
    coverage = study["held_out_coverage"]
    rows = [
        ["mean of e over Housner's", f"{float(study['restitution_over_housner_mean']):.3f}"],
        ["deviation of ln e from trial to trial, mean over H/B", f"{float(study['deviation_within']):.3f}"],
        ["deviation of ln e from block to block, mean over H/B", f"{float(study['deviation_between']):.3f}"],
        ["first ratios over Housner's, with their noise: mean", f"{float(study['first_ratio_mean']):.3f}"],
        ["their deviation from trial to trial", f"{float(study['first_ratio_deviation_within']):.3f}"],
        ["their deviation from block to block", f"{float(study['first_ratio_deviation_between']):.3f}"],
        ["noise of one ratio in it: deviation in the median trial", f"{float(study['noise']):.3f}"],
        ["odd and even impacts that differ: deviation", f"{float(study['alternation']):.3f}"],
        ["first ratios above 1", percent(study["first_ratios_above_one"])],
        ["first ratios of blocks not seen within their 90 % interval", percent(coverage.mean())],
        ["the same, least and most of all choices", f"{percent(coverage.min())}, {percent(coverage.max())}"],
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


def rocking_choices(data: Data) -> str:
    """How often the damper that made simulated trials is the most likely, and the exponent by bootstrap."""
    study = data["measured_rocking"]
    chosen = list(map(str, study["chosen"].values))
    rows = [
        [str(maker), *(str(int(count)) for count in study["simulated_choices"].sel(made_by=maker))]
        for maker in study["made_by"].values
    ]
    low, high = (f"{float(value):.2f}" for value in study["amplitude_exponent_bootstrap_interval"])
    sets = int(study["simulated_choices"].isel(made_by=0).sum())
    again = int(study["bootstrap_replicates"])
    told = (
        f"Each row is of {sets} sets: what all of them choose is chosen in at least {percent(0.05 ** (1 / sets))} of"
        f" such sets, at the level of 95 %.\n\n"
        f"The exponent lies between {low} and {high} in 90 % of {again} sets of trials"
        " that are drawn again."
    )
    return f"{table(('made by', *(f'{name} chosen' for name in chosen)), rows)}\n\n{told}"

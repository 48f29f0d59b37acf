"""Tables of docs/spectrum-method.md: an elastic spectrum at the secant period, and a code, against histories."""

from itertools import product

import xarray as xr
from table_text import interval, percent, table

from rockdamp.assessment.checks import CAPACITY as CHECKED
from rockdamp.figures.style import REFERENCE_RESTITUTION

Data = dict[str, xr.Dataset]


def spectrum_method(data: Data) -> str:
    """An elastic spectrum against histories: over all walls, and the walls with the least and most bias."""
    study = data["spectrum_method"].sel(capacity=CHECKED, method="nearest")
    place = {"ground": "ground", "storey": f"storey {int(study['storey'])} of {int(study['storeys'])}"}
    head = ["supports", "e", "damping", "bias", "bias of the walls", "scatter", "unsafe", "factor"]
    rows = []
    for support, e, damping in product(
        *(study[name].values for name in ("support", "restitution", "spectrum_damping"))
    ):
        at = study.sel(support=support, restitution=e, spectrum_damping=damping)
        kind = "5 %" if damping == "5 %" else f"ξ(e) = {percent(at['damping_ratio'])}"
        rows.append(
            [place[str(support)], f"{e:.2f}", kind, f"{float(at['overall_bias']):.2f}"]
            + [f"{float(at['bias'].min()):.2f} to {float(at['bias'].max()):.2f}", f"{float(at['overall_scatter']):.2f}"]
            + [percent(at["overall_unsafe_share"]), f"{float(at['overall_unsafe_factor']):.2f}"]
        )
    shown = study.sel(restitution=REFERENCE_RESTITUTION, method="nearest").sel(spectrum_damping="5 %")
    ground, storey = (
        f"{float(at['overall_bias']):.2f} times the capacity in the median, and {percent(at['overall_unsafe_share'])}"
        for at in (shown.sel(support=support) for support in place)
    )
    found = (
        f"With 5 % and e = {float(shown['restitution']):g} the demand is {ground} of walls and records pass and fail; "
        f"on {place['storey']} it is {storey}. The capacity is {CHECKED:g} u_ins, and the building has a period of "
        f"{float(study['building_period']):g} s."
    )
    return f"{found}\n\n{table(head, rows)}"


def code_checks(data: Data) -> str:
    """A code's check against histories: over all walls, and the walls with the least and the largest ratio."""
    study = data["code_checks"]
    head = ["limit state", "FC", "e", "S_d", "demand over capacity", "of the walls", "unsafe"]
    rows = []
    dims = ("limit_state", "confidence_factor", "restitution_rule", "period_range")
    for state, factor, rule, periods in product(*(study[name].values for name in dims)):
        at = study.sel(limit_state=state, confidence_factor=factor, restitution_rule=rule, period_range=periods)
        whole, walls = at.isel(wall=0), at["median_demand_ratio"].isel(wall=slice(1, None))
        e = "`measured`" if rule == "measured" else f"{float(at['restitution'].max()):.2f}"
        rows.append(
            [str(state), f"{factor:g}", e, str(periods), interval(whole, "median_demand_ratio")]
            + [f"{float(walls.min()):.2f} to {float(walls.max()):.2f}", percent(whole["unsafe_share"])]
        )
    return table(head, rows)

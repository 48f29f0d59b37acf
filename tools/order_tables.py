"""Tables of docs/earthquakes.md: how far the recommended damper is off, and which order of ECD is enough."""

import numpy as np
import xarray as xr
from table_text import models, percent, table

from rockdamp.report.earthquake_criterion import (
    MARKS,
    NONE,
    by_wall,
    changes,
    counted,
    reservations,
    sizes,
    smallest,
)
from rockdamp.report.earthquakes import Choice
from rockdamp.studies.earthquakes.orders import SIDES
from rockdamp.text import listed, number, plain
from rockdamp.vocabulary import DECISIVE_CHANGE, RECOMMENDED_ORDER, RECOMMENDED_SOURCE

Data = dict[str, xr.Dataset]


def by_band(data: Data, chosen: tuple[Choice, list[Choice]] | None) -> str:
    """Typical size, tail and root mean square by band of CR's peak, beside those of a change of e."""
    if not chosen:
        return ""
    compared, model = data["comparison"], chosen[0].model
    cell = compared.sel(damping_model=model, damping_ratio_source=RECOMMENDED_SOURCE)
    change = plain(data["recommendation"].get("restitution_change", xr.DataArray(np.nan)))
    head = ["peak of CR, u/u_ins"]
    for e in compared["restitution"].values.tolist():
        head += [f"e = {e:g}", f"e = {e:g}, e ∓ {change}"]
    rows = [[band, *(words for pair in cells for words in pair)] for band, cells in sizes(compared, cell)]
    return (
        f"\n\nError of the peaks with {model}, and with CR with e changed, the smaller one of both sides: median, 90 %"
        f" and root mean square of abs(ln r), each s as exp(s) - 1.\n\n{table(head, rows)}"
    )


def orders(data: Data) -> str:
    """How far ECD of each order is from CR beside CR with another e, and the order that is enough, also by wall."""
    compared = data["earthquakes/orders"]
    everywhere, named = compared.isel(record_set=0), changes(compared)
    at_e = compared["restitution"].values.tolist()
    head = ["e", *(f"m = {order:g}" for order in compared["order"].values.tolist())]
    head += [f"CR, {name}" for name in named.values()] + [f"smallest m, {name}" for name in named.values()]
    rows = []
    for one in (everywhere.sel(restitution=e) for e in at_e):
        sides = [[number(one["varied_log_error"].sel(variation=side), 2) for side in SIDES[name]] for name in named]
        errors = [number(error, 2) for error in one["log_error"]]
        least = [smallest(one["smallest_order"].sel(change=name)) for name in named]
        rows.append([f"{float(one['restitution']):g}", *errors, *map(", ".join, sides), *least])
    decided = compared.sel(change=DECISIVE_CHANGE)
    by_set = [[name, *map(smallest, of_set["smallest_order"])] for name, of_set in models(decided, "record_set")]
    enough, over = smallest(decided["recommended_order"]), f"{int(compared['records'])} records of "
    first = "No order is enough at every e" if enough == NONE else f"**Order {enough} is enough at every e**"
    head_by_set = ["records", *(f"e = {e:g}" for e in at_e)]
    walls = [[name, *(f"{least} {MARKS[verdict]}" for least, verdict in cells)] for name, cells in by_wall(compared)]
    against, m = reservations(compared), RECOMMENDED_ORDER
    return (
        f"{first} studied, over all walls together and {over}{int(compared['stations'])} stations, beside a"
        f" {named[DECISIVE_CHANGE]}.\n{against['change']} {against['walls']}\n{against['halves']}\n\n"
        f"Error of each order, and of CR with e changed:\n\n{table(head, rows)}\n\n"
        f"The smallest order that is enough beside a {named[DECISIVE_CHANGE]}, by set of records:\n\n"
        f"{table(head_by_set, by_set)}\n\n"
        f"The same by wall, and whether order {m} is enough by itself (✓ enough, ✗ exceeds, – undecided):\n\n"
        f"{table(['wall', *head_by_set[1:]], walls)}\n\n"
        f"Wall by wall, order {m} is enough for {listed(counted(compared))}, over {compared.sizes['drawing']} other"
        f" drawings of the bootstrap.\n\n{_typical(everywhere, named)}"
    )


def _typical(everywhere: xr.Dataset, named: dict[str, str]) -> str:
    """Typical size, tail, collapses missed and added of the recommended order, beside those of CR with e changed."""
    head = ["e", "what", f"m = {RECOMMENDED_ORDER}", *(f"CR, {name}" for name in named.values())]
    what = {"log_error_median": "median of abs(ln r)", "log_error_90": "90 % of abs(ln r)", "log_error": "error"}
    rows = []
    for e in everywhere["restitution"].values.tolist():
        one = everywhere.sel(restitution=e)
        of_order = one.sel(order=RECOMMENDED_ORDER, method="nearest")
        for name, words in what.items():
            sides = [one[f"varied_{name}"].sel(variation=list(SIDES[change])).min() for change in named]
            rows.append([f"{e:g}", words, number(of_order[name], 2), *(number(side, 2) for side in sides)])
        for side, (name, words) in enumerate({"safe": "collapses missed", "collapse": "collapses added"}.items()):
            varied = [one[f"varied_false_{name}_rate"].sel(variation=SIDES[change][side]) for change in named]
            rows.append([f"{e:g}", words, percent(of_order[f"false_{name}_rate"]), *map(percent, varied)])
    return (
        f"Order {RECOMMENDED_ORDER} by error, collapses missed and added, beside the side of each change that it is"
        " compared with:"
        f"\n\n{table(head, rows)}"
    )

"""How far a damper is from restitution beside another e, in words: typical size and tail, and which order is enough."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.mechanics.damping import Damping
from rockdamp.text import at_most, listed, number, percent, plain, span
from rockdamp.vocabulary import DECISIVE_CHANGE, RECOMMENDED_ORDER, RECOMMENDED_SOURCE

NONE = "none"
VERDICTS = {1: "enough", 0: "undecided", -1: "exceeds"}
MARKS = {"enough": "✓", "undecided": "–", "exceeds": "✗"}
ALL_WALLS = "all together"
NAMED = {"tested": "the paper's tested wall"}  # whose name alone does not say which wall it is


# --- typical size and tail --------------------------------------------------------------------------------------------

SIZES = ("log_error_median", "log_error_90", "log_error")  # of the difference of the peaks
SIDES = ["lower e", "higher e"]


def off(log_error: Any) -> str:
    """Return a size of the logarithm of a ratio as the percentage that it stands for."""
    return percent(np.expm1(float(log_error)))


def sizes(compared: xr.Dataset, cell: xr.Dataset) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return, for all peaks and each band of CR's, what a damper and a change of e make at each e.

    Median, 90 % and root mean square of the size of ln r, of the change the smaller one of both sides.
    """
    varied = {name: compared[f"varied_{name}"].sel(variation=SIDES).min("variation") for name in SIZES}
    rows = []
    for band in range(compared.sizes["band"]):
        ends = f"{plain(compared['band_start'][band])} to {plain(compared['band_end'][band])}"
        at_band = [
            (
                "; ".join(off(cell[name].isel(at)) for name in SIZES),
                "; ".join(off(varied[name].isel(at)) for name in SIZES),
            )
            for at in ({"restitution": e, "band": band} for e in range(compared.sizes["restitution"]))
        ]
        rows.append(("all" if band == 0 else ends, at_band))
    return rows


# --- which damping ratio ----------------------------------------------------------------------------------------------

CLOSED_FORM = "closed form"


def by_source(compared: xr.Dataset, walls: xr.Dataset, models: list[str], names: Mapping[str, str]) -> dict[str, Any]:
    """Return errors and missed collapses of each damper by the source of its ratio, and why one source leads."""
    others = [str(source) for source in compared["damping_ratio_source"].values if source != RECOMMENDED_SOURCE]
    order = [RECOMMENDED_SOURCE, *reversed(others)]
    error, missed = (compared[name].sel(damping_ratio_source=order) for name in ("log_error", "false_safe_rate"))
    error = error.isel(band=0)

    def cells(model: str) -> list[tuple[str, str]]:
        errors, shares = (one.sel(damping_model=model).transpose("restitution", ...).values for one in (error, missed))
        return [
            ("; ".join(number(value, 2) for value in at_e), "; ".join(map(percent, shares_at_e)))
            for at_e, shares_at_e in zip(errors, shares, strict=True)
        ]

    return {
        "leading": names[RECOMMENDED_SOURCE],
        "source_order": [names.get(source, source) for source in order],
        "by_source": [(model, cells(model)) for model in models],
        "reason": _reason(error.sel(damping_model=models), missed, walls),
    }


def _reason(error: xr.DataArray, missed: xr.DataArray, walls: xr.Dataset) -> dict[str, Any] | None:
    """Compare the errors of the leading source with those of the closed form: the largest gain, the largest loss."""
    sources = (RECOMMENDED_SOURCE, CLOSED_FORM)
    leading, closed = (error.sel(damping_ratio_source=source, drop=True) for source in sources)
    more = closed / leading - 1
    middle = more.isel(restitution=more.sizes["restitution"] // 2)
    if not np.isfinite(more).all():
        return None
    worst = str(middle["damping_model"].values[int(np.argmax(middle.values))])
    at = {"damping_model": worst, "restitution": middle["restitution"]}
    rates = [float(missed.sel(at).sel(damping_ratio_source=source)) for source in sources]
    exact = [model for model in Damping.exact_models() if model in error["damping_model"].values]
    ratio = walls["damping_ratio"]
    apart = abs(ratio.sel(damping_ratio_source=sources[0]) / ratio.sel(damping_ratio_source=sources[1]) - 1)
    return {
        "model": worst,
        "e": plain(middle["restitution"]),
        "leading": number(leading.sel(at), 2),
        "closed": number(closed.sel(at), 2),
        "loss": at_most(max(0.0, -float(more.min()))),
        "missed": percent(rates[0]),
        "missed_closed": percent(rates[1]),
        "missed_more": rates[0] > rates[1],
        "exact": listed(exact),
        "apart": listed(at_most(apart.sel(damping_model=model).max()) for model in exact),
    }


# --- which order ------------------------------------------------------------------------------------------------------


def changes(orders: xr.Dataset) -> dict[str, str]:
    """Name each change of e that orders are judged against: "loss ± 7 %"."""
    return {
        "e": f"e ∓ {plain(orders['restitution_change'])}",
        "loss": f"loss ± {percent(orders['loss_change'], 1)}",
        "tests": f"ln e ∓ {plain(orders['test_spread'])}",
    }


def smallest(order: xr.DataArray) -> str:
    """Write the smallest order that is enough, or that there is none."""
    return plain(order) if np.isfinite(order) else NONE


def by_wall(orders: xr.Dataset) -> list[tuple[str, list[tuple[str, str]]]]:
    """Return, for all walls and for each, the smallest order and the verdict on the recommended one, by e.

    All records, beside the change of e that decides.
    """
    judged = orders.isel(record_set=0).sel(change=DECISIVE_CHANGE)
    rows = [(ALL_WALLS, judged["smallest_order"], judged["verdict"])]
    rows += [
        (str(wall), judged["wall_smallest_order"].sel(wall=wall), judged["wall_verdict"].sel(wall=wall))
        for wall in orders["wall"].values
    ]
    return [
        (name, [(smallest(order), of_order) for order, of_order in zip(least, verdicts(verdict), strict=True)])
        for name, least, verdict in rows
    ]


def verdicts(verdict: xr.DataArray) -> list[str]:
    """Return the words of the verdicts on the recommended order, over the last dimension that is left."""
    of_order = verdict.sel(order=RECOMMENDED_ORDER, method="nearest")
    return [VERDICTS[int(value)] for value in of_order.values.ravel()]


def _drawn(orders: xr.Dataset) -> xr.DataArray:
    """Return for how many walls the recommended order is enough, by drawing of the bootstrap and e."""
    return orders["drawn_wall_count"].sel(change=DECISIVE_CHANGE).sel(order=RECOMMENDED_ORDER, method="nearest")


def counted(orders: xr.Dataset) -> list[str]:
    """Say at each e for how many walls the recommended order is enough, by drawing: "2 to 4 of 8 walls at e = 0.75"."""
    of = f"of {orders.sizes['wall']} walls at e ="
    drawn = _drawn(orders)
    return [f"{span(drawn.sel(restitution=e), _count)} {of} {plain(e)}" for e in orders["restitution"].values]


def _count(value: Any) -> str:
    return str(int(value))


def counted_in_short(orders: xr.Dataset) -> str:
    """Say for how many walls the recommended order is enough, over all e and drawings, and what the others are."""
    judged = orders.isel(record_set=0).sel(change=DECISIVE_CHANGE)["wall_verdict"]
    words = verdicts(judged)
    others = [name for name, word in (("undecided", "undecided"), ("beyond the limit", "exceeds")) if word in words]
    rest = f"; the others are {' or '.join(others)}" if others else ""
    walls = f"{span(_drawn(orders), _count)} of {orders.sizes['wall']} walls"
    return f"{walls}, by e and by the drawing of the bootstrap{rest}"


def reservations(orders: xr.Dataset) -> dict[str, str]:
    """Say in a sentence each what speaks against the recommended order; empty where nothing does.

    ``change``: where a change of e by the same amount everywhere asks for more. ``halves``: how often halves of the
    stations agree. ``walls``: the walls for which no order is shown to be enough at any e.
    """
    m, told, judged = RECOMMENDED_ORDER, splits(orders), orders.isel(record_set=0)
    least = judged["smallest_order"].sel(change="e")
    more = [
        f"{name} at e = {plain(order['restitution'])}"
        for order, name in ((order, smallest(order)) for order in least)
        if name == NONE or float(order) > m
    ]
    of_wall = judged["wall_smallest_order"].sel(change=DECISIVE_CHANGE)
    undecided = orders["wall"].values[of_wall.isnull().all("restitution").values]
    never = [NAMED.get(name, name) for name in map(str, undecided)]
    beside = f"Beside {changes(orders)['e']}, over all walls together, the smallest order that is enough is"
    return {
        "change": f"{beside} {listed(more)}." if more else "",
        "halves": f"Order {m} was chosen on one half of the stations and enough on the other in {told['both']} of"
        f" {told['count']} splits; whatever was chosen, order {m} was enough there in {told['recommended_passes']}.",
        "walls": f"For {listed(never)} no order is shown to be enough at any e." if never else "",
    }


def splits(orders: xr.Dataset) -> dict[str, str]:
    """Say how often each order is chosen on one half of the stations, and what the other half says of it.

    ``chosen`` lists the orders with their shares, ``both`` is the share of the splits in which the recommended one is
    chosen and enough on the other half.
    """
    one = orders.sel(change=DECISIVE_CHANGE)
    chosen, of_other = one["split_order"].values, one["split_verdict"]
    names = ["none" if np.isnan(order) else plain(order) for order in chosen]
    ranked = sorted(set(names), key=lambda name: (-names.count(name), name))
    of_recommended = of_other.sel(order=RECOMMENDED_ORDER, method="nearest").values
    return {
        "count": str(chosen.size),
        "chosen": listed(f"{name} in {percent(names.count(name) / chosen.size)}" for name in ranked),
        "both": percent(((chosen == RECOMMENDED_ORDER) & (of_recommended == 1)).mean()),
        "recommended_passes": percent((of_recommended == 1).mean()),
        "recommended_exceeds": percent((of_recommended == -1).mean()),
    }

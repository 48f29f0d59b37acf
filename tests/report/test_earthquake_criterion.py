"""Which order is enough, and how far a damper is off, in words: counted from made-up verdicts and sizes."""

import made_up_earthquakes as made_up
import numpy as np
import pytest
import xarray as xr
from report_content import of_name

from rockdamp.report import earthquake_criterion as criterion
from rockdamp.vocabulary import DECISIVE_CHANGE, RECOMMENDED_ORDER


@pytest.fixture
def orders():
    """Made-up verdicts of two orders, by wall and e, all enough beside every change of e but where a test says so."""
    made = of_name("earthquakes/orders").isel(order=[0, 1]).assign_coords(order=[4.0, float(RECOMMENDED_ORDER)])
    enough = {name: xr.ones_like(made[name]) for name in ("verdict", "wall_verdict")}
    least = {name: made[name] * 0 + 4 for name in ("smallest_order", "wall_smallest_order")}
    return made.assign({**enough, **least})


def test_walls_stand_beside_all_walls_together_with_the_smallest_order_and_the_verdict_on_the_recommended_one(orders):
    at = {"record_set": 0, "change": DECISIVE_CHANGE, "wall": "church", "restitution": 0.85}
    orders["wall_verdict"].loc[{**at, "order": RECOMMENDED_ORDER}] = -1
    orders["wall_verdict"].loc[{**at, "order": 4.0, "restitution": 0.9}] = -1  # of another order
    orders["wall_verdict"].loc[{**at, "change": "tests"}] = -1  # beside another change
    orders["wall_smallest_order"].loc[at] = np.nan
    told = dict(criterion.by_wall(orders))
    assert list(told) == [criterion.ALL_WALLS, "veneer", "church", "parapet"]
    assert told["church"] == [("4", "enough"), ("none", "exceeds"), ("4", "enough"), ("4", "enough")]
    assert set(told["veneer"]) == set(told[criterion.ALL_WALLS]) == {("4", "enough")}


def test_walls_are_counted_at_each_e_from_the_least_to_the_most_of_the_drawings(orders):
    at = {"change": DECISIVE_CHANGE, "order": RECOMMENDED_ORDER}
    orders["drawn_wall_count"][:] = 0
    orders["drawn_wall_count"].loc[at] = 3
    orders["drawn_wall_count"].loc[{**at, "restitution": 0.95}][0] = 1
    told = criterion.counted(orders)
    assert told[0] == "3 of 3 walls at e = 0.8" and told[-1] == "1 to 3 of 3 walls at e = 0.95"
    short = "1 to 3 of 3 walls, by e and by the drawing of the bootstrap"
    assert criterion.counted_in_short(orders) == short
    orders["wall_verdict"].loc[{"record_set": 0, **at, "restitution": 0.9, "wall": "church"}] = 0
    assert criterion.counted_in_short(orders) == f"{short}; the others are undecided"


def test_each_reservation_is_made_only_where_the_numbers_make_it(orders):
    orders["split_order"][:] = orders["split_verdict"][:] = 1
    told = criterion.reservations(orders)
    assert told["change"] == told["walls"] == "" and "0\u00a0% of" in told["halves"]
    orders["smallest_order"].loc[{"record_set": 0, "change": "e", "restitution": 0.8}] = 32
    orders["smallest_order"].loc[{"record_set": 0, "change": "e", "restitution": 0.95}] = np.nan
    orders["smallest_order"].loc[{"record_set": 0, "change": "loss"}] = 64
    at = {"record_set": 0, "change": DECISIVE_CHANGE}
    orders["wall_smallest_order"].loc[{**at, "wall": "parapet"}] = np.nan
    orders["wall_smallest_order"].loc[{**at, "wall": "church", "restitution": 0.8}] = np.nan
    told = criterion.reservations(orders)
    assert told["change"].endswith(" the smallest order that is enough is 32 at e = 0.8 and none at e = 0.95.")
    assert told["walls"] == "For parapet no order is shown to be enough at any e."


def test_halves_are_counted_by_the_order_chosen_and_by_what_the_other_half_says_of_it():
    chosen = [16.0, 16.0, 4.0, np.nan, 16.0]
    verdict = np.array([[-1, 1], [-1, -1], [1, 1], [1, 1], [1, 0]])
    orders = xr.Dataset(
        {"split_order": ("split", chosen), "split_verdict": (("split", "order"), verdict)},
        coords={"order": [4.0, float(RECOMMENDED_ORDER)]},
    ).expand_dims(change=[DECISIVE_CHANGE])
    told = criterion.splits(orders)
    assert told["count"] == "5" and told["chosen"] == "16 in 60\u00a0%, 4 in 20\u00a0% and none in 20\u00a0%"
    assert told["both"] == "20\u00a0%"
    assert (told["recommended_passes"], told["recommended_exceeds"]) == ("60\u00a0%", "20\u00a0%")


def test_sizes_stand_beside_the_smaller_side_of_the_change_of_e_in_each_band():
    compared = made_up.comparison()
    cell = compared.sel(damping_model="CDR", damping_ratio_source="closed form")
    values = {"log_error_median": 0.01, "log_error_90": 0.05, "log_error": 0.1}
    for name, value in values.items():
        band = xr.DataArray(np.arange(compared.sizes["band"]), dims="band")
        cell = cell.assign({name: (value * (1 + band)).expand_dims(restitution=compared["restitution"])})
        sides = xr.DataArray([9.0, 9.0, 3 * value, 2 * value], dims="variation")
        compared[f"varied_{name}"] = xr.zeros_like(compared["varied_log_error"]) + sides
    rows = criterion.sizes(compared, cell)
    assert [band for band, _ in rows][:2] == ["all", "0.01 to 0.04"] and len(rows) == made_up.EDGES.size
    expected = "; ".join(criterion.off(value) for value in values.values())
    doubled = "; ".join(criterion.off(2 * value) for value in values.values())
    assert rows[0][1] == [(expected, doubled)] * made_up.E.size
    assert rows[1][1][0][0] == doubled

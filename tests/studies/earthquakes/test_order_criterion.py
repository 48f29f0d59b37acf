"""The rule that says whether an order is enough: what is compared, over which histories, and how halves are used."""

from dataclasses import replace

import numpy as np
import pytest
from configs import configured
from made_up_orders import compare, made_up

from rockdamp.studies.earthquakes import orders
from rockdamp.studies.earthquakes.orders import ENOUGH, EXCEEDS, SIDES, UNDECIDED, Sums

EARTHQUAKES = configured().earthquakes


def test_every_change_of_e_is_what_its_name_says():
    e = np.array([0.75, 0.85, 0.95])
    lower, higher, more, less, low, high = orders.changed(e, 0.01, 0.07, 0.03).T
    np.testing.assert_allclose((e - lower, higher - e), 0.01)
    np.testing.assert_allclose(np.log([more, less]) / np.log(e), np.array([[1.07], [0.93]]) * np.ones(3))
    np.testing.assert_allclose((np.log(e / low), np.log(high / e)), 0.03)


def test_the_change_of_the_loss_is_a_hundredth_of_e_where_the_papers_tests_are():
    part = EARTHQUAKES.restitution_change / (0.85 * -np.log(0.85))
    assert EARTHQUAKES.orders.loss_change == pytest.approx(part, rel=0.05)
    # What a hundredth is at the ends, as docs/earthquakes.md says.
    ends = [round(100 * EARTHQUAKES.restitution_change / (e * -np.log(e))) for e in (0.75, 0.95)]
    assert ends == [5, 21]


def test_an_error_is_compared_with_the_smaller_one_of_both_sides():
    for lower, higher in ((0.1, -0.25), (0.25, -0.1)):
        histories = made_up(np.array([0.3, 0.05]))
        for side, ratio in zip(SIDES["loss"], (lower, higher), strict=True):
            histories["varied_peak"].loc[{"variation": side}] = 0.1 * np.exp(ratio)
        excess = compare(histories)["excess"].sel(measure="log_error")
        np.testing.assert_allclose(excess, [0.2, -0.05], atol=1e-12)


def test_histories_in_which_a_changed_restitution_collapses_are_no_pair():
    histories = made_up(np.array([0.05]))
    fallen = {"variation": "more loss", "record": [f"r{i}" for i in range(10)], "velocity_ratio": 0.5}
    histories["varied_collapsed"].loc[fallen] = 1
    # There the order would be far off; its collapse under the changed CR leaves these out.
    histories["peak"].loc[{name: fallen[name] for name in ("record", "velocity_ratio")}] = 0.9
    assert compare(histories)["excess"].sel(measure="log_error").item() == pytest.approx(0.05 - 0.1)


@pytest.mark.parametrize(
    ("measure", "side", "velocity_ratio", "falls"),
    [("false_safe_rate", "more loss", 2.0, 0), ("false_collapse_rate", "less loss", 1.0, 1)],
)
def test_false_answers_are_compared_with_the_side_of_the_change_that_makes_them(measure, side, velocity_ratio, falls):
    histories = made_up(np.array([0.05]))
    cases = 40 if measure == "false_safe_rate" else 80
    first = [f"r{i}" for i in range(6)]
    histories["collapsed"].loc[{"record": first, "velocity_ratio": velocity_ratio}] = falls
    assert compare(histories)["excess"].sel(measure=measure).item() == pytest.approx(6 / cases)
    other = set(SIDES["loss"]) - {side}
    histories["varied_collapsed"].loc[{"variation": other.pop(), "velocity_ratio": velocity_ratio}] = falls
    assert compare(histories)["excess"].sel(measure=measure).item() == pytest.approx(6 / cases)
    histories["varied_collapsed"].loc[{"variation": side, "record": first[:4], "velocity_ratio": velocity_ratio}] = (
        falls
    )
    assert compare(histories)["excess"].sel(measure=measure).item() == pytest.approx(2 / cases)


def test_a_verdict_needs_the_whole_interval_of_every_measure():
    enough, zero, over, across = (-0.2, -0.1), (0.0, 0.0), (0.1, 0.2), (-0.1, 0.1)
    unknown = (np.nan, np.nan)
    cases = [
        ([enough, zero, enough], ENOUGH),
        ([enough, across, enough], UNDECIDED),
        ([over, across, enough], EXCEEDS),
        ([enough, enough, unknown], UNDECIDED),
        ([over, enough, unknown], EXCEEDS),
    ]
    for bounds, expected in cases:
        assert orders.verdict(np.array(bounds)) == expected


@pytest.mark.parametrize(
    ("judged", "smallest"),
    [
        ([EXCEEDS, ENOUGH, ENOUGH], 1.0),
        ([ENOUGH, UNDECIDED, ENOUGH], 2.0),  # from there on, and not the first by chance
        ([ENOUGH, ENOUGH, ENOUGH], 0.0),
        ([EXCEEDS, EXCEEDS, UNDECIDED], np.nan),
    ],
)
def test_the_smallest_order_is_that_from_which_on_all_are_enough(judged, smallest):
    order = orders.smallest_order(np.arange(3.0), np.array(judged))
    assert order == pytest.approx(smallest, nan_ok=True)


@pytest.mark.parametrize("smallest, recommended", [([16.0, 2.0, 0.0], 16.0), ([16.0, np.nan], np.nan)])
def test_the_recommended_order_is_enough_at_every_restitution(smallest, recommended):
    assert orders.recommended_order(np.array(smallest)) == pytest.approx(recommended, nan_ok=True)


def test_an_order_is_chosen_and_judged_on_halves_that_share_no_station():
    histories = made_up(np.array([0.3, 0.05]))
    found = compare(histories)
    np.testing.assert_array_equal(found["split_order"], 1.0)
    np.testing.assert_array_equal(found["split_verdict"].sel(order=[0, 1]), [[EXCEEDS, ENOUGH]] * 3)
    sums = Sums.from_histories(histories, "loss")
    seen = []

    def remembered(part, weights):
        seen.append(part.stand[:, 0, 0, 0])
        return None, None, np.array([[[ENOUGH, ENOUGH]]], dtype=np.int8)

    sums = replace(sums, stand=np.arange(40.0)[:, None, None, None] * np.ones_like(sums.stand))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(orders, "judge", remembered)
        orders.split(sums, np.arange(2.0), histories["station"].values, 3, 10, 1)
    for first, second in zip(seen[::2], seen[1::2], strict=True):
        assert sorted([*first, *second]) == list(range(40))
        assert not {int(i) // 2 for i in first} & {int(i) // 2 for i in second}
        assert len(first) == len(second) == 20
    assert not np.array_equal(seen[0], seen[2])


def test_one_station_alone_has_no_halves():
    histories = made_up(np.array([0.3, 0.05])).isel(record=[0, 1])
    found = compare(histories)
    assert np.isnan(found["split_order"]).all() and (found["split_verdict"] == UNDECIDED).all()


def test_the_half_that_judges_an_order_is_not_the_one_that_chose_it(monkeypatch):
    """By hand: station 0 finds order 0 enough at either e, station 1 at the first alone: each disagrees with the other.

    An order is no better than it is at the worst e.
    """
    histories = made_up(np.array([0.3, 0.05]))
    sums = Sums.from_histories(histories, "loss")
    sums = replace(sums, stand=np.arange(40.0)[:, None, None, None] * np.ones_like(sums.stand))

    def by_station(part, weights):
        at_the_second = ENOUGH if 0 in part.stand else EXCEEDS
        return None, None, np.array([[[ENOUGH] * 2, [at_the_second] * 2]], dtype=np.int8)

    monkeypatch.setattr(orders, "judge", by_station)
    found = orders.split(sums, np.arange(2.0), np.repeat([0, 1], 20), 12, 10, 1)
    chose = found["split_order"].values == 0
    assert chose.any() and not chose.all() and np.isnan(found["split_order"].values[~chose]).all()
    np.testing.assert_array_equal(found["split_verdict"].values[chose], EXCEEDS)
    np.testing.assert_array_equal(found["split_verdict"].values[~chose], ENOUGH)

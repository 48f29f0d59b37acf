"""Models and walls are told apart."""

from itertools import combinations

from rockdamp.figures.style import LOOK, look, series


def test_models_and_walls_are_told_apart_without_colour():
    for one, other in combinations(LOOK, 2):
        assert look(one)["linestyle"] != look(other)["linestyle"] and look(one)["marker"] != look(other)["marker"]
    assert len({(line["color"], line["marker"]) for line in map(series, range(24))}) == 24
    assert look("ECD16") == look("ECD") and look("BAND0.4", marker="")["color"] == look("BAND")["color"]

"""The figures of walls that rock to one side."""

import numpy as np
import pytest
from figure_reading import drawn
from made_up_studies import made_up

import rockdamp as rd
from rockdamp.figures.one_sided import history_figure, one_sided_wall_figure
from rockdamp.histories.one_sided import response

TIED = rd.OneSidedWall(rd.Parapet(0.8, 12.0), rd.Tie(2e6, 6e3, gap=0.01))
CURVE = rd.TrilinearCurve(0.04, 0.85)


def test_the_study_shows_the_dampers_at_the_stop_and_the_two_sided_wall():
    figure, data = drawn("fig_one_sided"), made_up()["one_sided"]
    peaks, falls = figure.axes
    e = float(data["restitution"].values[(data.sizes["restitution"] - 1) // 2])
    stops = [name for name in data["alternative"].values if "stop" in str(name)]
    shown = peaks.get_legend_handles_labels()[1]
    assert shown == stops
    for line, name in zip(falls.get_lines()[1:], data["wall"].values, strict=True):
        ratio = data["two_sided_intensity_ratio"].sel(restitution=e, wall=name)
        assert line.get_ydata() == pytest.approx(ratio.values, nan_ok=True)


def test_the_history_is_drawn_in_millimetres():
    time = 0.01 * np.arange(300)
    record = rd.Record(time, 2 * np.sin(3 * time))
    history = response(record, TIED, CURVE, 0.5)
    (_, axes) = history_figure(history).axes
    assert axes.get_lines()[0].get_ydata() == pytest.approx(
        1000 * history["control_displacement"][0].values, nan_ok=True
    )


def test_the_sketch_has_stop_and_tie_and_the_force_with_and_without_it():
    sketch, forces = one_sided_wall_figure(TIED, CURVE).axes
    assert {"stop", "tie"} <= {text.get_text() for text in sketch.texts}
    assert [line.get_label() for line in forces.get_lines()] == [
        "rigid wall",
        "this wall",
        "with its ties, stretched once",
    ]
    x, force = forces.get_lines()[2].get_data()
    at = np.argmin(np.abs(x - 200.0))  # mm, where the tie yields: its force counts twice in F
    _, own = forces.get_lines()[1].get_data()
    assert force[at] - own[at] == pytest.approx(2 * 6.0, rel=1e-9)

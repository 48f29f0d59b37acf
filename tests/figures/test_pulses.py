"""The map of the pulses: where a damper judges otherwise than restitution."""

import numpy as np
from figure_functions import FIGURES
from made_up_studies import VISCOUS, pulses
from matplotlib.colors import to_rgb

from rockdamp.figures.style import style_of


def test_the_pulses_that_one_of_both_survives_are_marked_on_the_map_and_no_others():
    data = pulses()
    at_e = data.sel(restitution=0.85, damping_ratio_source="closed form")
    maps = [axes for axes in FIGURES["fig_pulses"](data).axes if axes.get_xlabel().startswith("pulse")]
    marked = 0
    for axes, shape in zip(maps, data["pulse"].values, strict=True):
        of_pulse = at_e.sel(pulse=shape).transpose(..., "pulse_frequency", "load_ratio")
        for model in VISCOUS:
            reference, damper = of_pulse["reference_collapsed"], of_pulse["collapsed"].sel(damping_model=model)
            at = np.argwhere(reference.values != damper.values)
            expected = {(float(data["pulse_frequency"][i]), float(data["load_ratio"][j])) for i, j in at}
            (marks,) = (line for line in axes.get_lines() if to_rgb(line.get_color()) == to_rgb(style_of(model).colour))
            assert set(zip(*marks.get_data(), strict=True)) == expected
            marked += len(expected)
    assert 0 < marked < at_e["collapsed"].size / 2

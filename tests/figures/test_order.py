"""The figure of error against force: a line for each family, and the force and velocity of a decay."""

import numpy as np
import pytest
from figure_reading import drawn, labelled, shows
from made_up_studies import order

E = 0.85


@pytest.mark.parametrize("family", ["ECD", "BAND", "CQD"])
@pytest.mark.parametrize(("panel", "measure"), [(0, "log_error_median"), (1, "log_error_90")])
def test_the_errors_of_a_family_stand_over_its_forces_on_the_paper_s_curve(panel, measure, family):
    at_e = order().sel(restitution=E, damper=[name for name in order()["damper"].values if name.startswith(family)])
    axes = drawn("fig_order").axes[panel]
    assert shows(axes, at_e["crossing_force"].sel(wall="paper").values, at_e[measure].values)


def test_the_force_is_shown_up_to_the_first_turn():
    data = order().sel(shown_damper="BAND0.2")
    line = labelled(drawn("fig_order").axes[2], "BAND0.2")
    count = line.get_xdata().size
    np.testing.assert_array_equal(line.get_ydata(), data["shown_damping_force"].values[:count])
    assert data["shown_velocity"].values[count] >= 0 > data["shown_velocity"].values[1 : count - 1].max()

"""The orders of convergence."""

import numpy as np
import pytest
from figure_reading import drawn, labelled
from made_up_studies import ALL, made_up


def test_fig_convergence_shows_errors_measured_orders_and_true_slopes():
    data = made_up()["convergence"]
    panels = iter(drawn("fig_convergence").axes)
    for scheme in ("newmark", "paper"):
        for excitation in ("free", "forced"):
            axes, one = next(panels), data.sel(scheme=scheme, excitation=excitation)
            assert axes.get_xscale() == axes.get_yscale() == "log"
            for model in ALL:
                curve = one.sel(damping_model=model)
                line = labelled(axes, f"{model}:")
                assert line.get_ydata() == pytest.approx(curve["solver_error"].values)
                assert (
                    f"{float(curve['convergence_order']):.2f} ({float(curve['finest_convergence_order']):.2f})"
                    in line.get_label()
                )
            guides = [line for line in axes.get_lines() if str(line.get_label()).startswith("_")]
            slopes = [np.polyfit(np.log(line.get_xdata()), np.log(line.get_ydata()), 1)[0] for line in guides]
            assert slopes == pytest.approx([1.0, 2.0])

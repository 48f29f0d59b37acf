"""The program that draws the losses of free-rocking tests: its specimens lose as they should."""

import check_losses
import numpy as np
import pandas as pd
import pytest


@pytest.mark.parametrize("g", check_losses.MAKERS.values())
def test_drawn_losses_follow_their_law_about_the_scatter(g):
    residuals = []
    for number in range(100):
        losses, log_energy, at, e = check_losses.impacts(np.random.RandomState([3, number]), g)
        power = np.exp(-g * (log_energy - at))
        law = -np.log1p(np.expm1(2 * g * np.log(e)) * power) / (2 * g) if g else np.full(log_energy.size, -np.log(e))
        kept = np.isfinite(law) & (power < 2.0)
        residuals.append((losses.decrement - law)[kept])
        np.testing.assert_allclose(losses.covariance, losses.covariance.T)
    residuals = np.concatenate(residuals)
    assert abs(residuals.mean()) < 4 * 0.03 / np.sqrt(residuals.size) and residuals.std() < 0.04


def test_the_stored_check_holds_for_e_and_g_of_every_maker():
    rows = pd.read_csv(check_losses.FILE).to_dict("records")
    assert [(row["made_by"], row["parameter"]) for row in rows] == [
        (maker, name) for maker in check_losses.MAKERS for name in ("e", "g")
    ]
    assert all(map(check_losses.good, rows))

"""Measured trials of blocks: their file, and what each damper predicts for a block."""

import numpy as np
import pytest
from repository import ROOT

from rockdamp.constants import BLOCK_RESTITUTION_DEVIATION
from rockdamp.errors import InputError
from rockdamp.laboratory import trials as blocks
from rockdamp.laboratory.trials import (
    losses_by_impact,
    make_trials,
    power_law,
    predict_damper,
    read_rocking_trials,
)
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset

COLUMNS = "# synthetic: no\ngroup,trial,duplicate_of_trial,thickness_m,height_m,depth_m,mass_kg,impact,ratio\n"
ROWS = [
    "1,1,,0.05,0.2,0.1,3.0,1,0.95",
    "1,1,,0.05,0.2,0.1,3.0,2,0.90",
    "2,1,,0.05,0.3,0.1,4.0,1,0.97",
]
COPY = ["1,2,1,0.05,0.2,0.1,3.0,1,0.95", "1,2,1,0.05,0.2,0.1,3.0,2,0.90"]
LOSS = np.array([0.01, 0.03, 0.08])


def read(folder, rows, columns=COLUMNS):
    (folder / "trials.csv").write_text(columns + "\n".join(rows) + "\n", encoding="utf-8")
    return read_rocking_trials(folder / "trials.csv")


def test_measured_trials_are_those_of_their_header():
    rows = read_rocking_trials(ROOT / "data/measured/limestone-free-rocking.csv")
    trials = make_trials(rows, rows["impact"].max())
    assert len(rows) == 7545 and trials.ratio.shape[0] == trials.geometry.size == 134
    sine = 1 / np.hypot(1, 1 / np.arange(4, 16))
    np.testing.assert_allclose(trials.housner, -np.log(1.5 * sine**2 - 0.5), rtol=1e-12)
    counts = np.isfinite(trials.ratio).sum(axis=1)
    assert (np.diff(counts) <= 0).all() and counts.sum() == 7545 - 26  # those of the duplicate


def test_duplicate_is_left_out(tmp_path):
    trials = make_trials(read(tmp_path, [*ROWS[::-1], *COPY[::-1]][::-1]), 2)
    np.testing.assert_array_equal(trials.ratio, [[0.95, 0.90], [0.97, np.nan]])
    assert trials.geometry.tolist() == [0, 1]
    assert make_trials(read(tmp_path, ROWS), 1).ratio.tolist() == [[0.95], [0.97]]


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"columns": COLUMNS.replace(",ratio", "")}, "columns"),
        ({"rows": [ROWS[0], ROWS[2], ROWS[1].replace(",2,0.90", ",3,0.90")]}, "trial 1 of group 1"),
        ({"rows": [ROWS[0].replace("0.95", "nan")]}, "row 1"),
        ({"rows": [*ROWS, ROWS[2].replace("2,1,,0.05", "2,2,,0.06")]}, "group 2"),
    ],
)
def test_invalid_table_is_refused(tmp_path, change, named):
    with pytest.raises(InputError, match=named) as error:
        read(tmp_path, **{"rows": ROWS, **change})
    assert "trials.csv" in str(error.value)


# --- predictions ------------------------------------------------------------------------------------------------------


def test_power_law_loses_by_the_energy_left():
    ratio, log_energy = power_law(LOSS, 0.0, 5)
    np.testing.assert_allclose(ratio, np.exp(-np.broadcast_to(LOSS, (5, 3))), rtol=1e-14)
    np.testing.assert_allclose(log_energy, -2 * np.arange(5)[:, None] * LOSS, rtol=1e-12)
    ratio, log_energy = power_law(LOSS, 0.5, 5)
    np.testing.assert_allclose(-np.log(ratio), LOSS * np.exp(0.5 * log_energy), rtol=1e-12)
    np.testing.assert_allclose(np.diff(log_energy, axis=0), 2 * np.log(ratio[:-1]), rtol=1e-12)


@pytest.mark.parametrize("model", ["CR", "ECD", "BAND"])
def test_amplitude_independent_dampers_predict_one_ratio(model):
    ratio = predict_damper(model, 8)(LOSS, 0.0).ratio
    np.testing.assert_allclose(np.log(ratio), -np.broadcast_to(LOSS, (8, 3)), atol=3e-4)


@pytest.mark.parametrize(("model", "exponent"), [("CDC", 0.5), ("CDR", 0.0), ("SDR", -0.5)])
def test_dampers_of_the_paper_follow_a_power_law(model, exponent, monkeypatch):
    """To first order in the loss, on a rigid block from a small release, where the force hardly changes."""
    monkeypatch.setattr(blocks, "CURVE", TrilinearCurve(0.002, 0.996))
    monkeypatch.setattr(blocks, "RELEASE", 0.1)
    loss = np.array([0.002, 0.004])
    found, law = predict_damper(model, 6)(loss, 0.0), power_law(loss, exponent, 6)
    np.testing.assert_allclose(np.log(found.ratio) / np.log(law.ratio), 1.0, atol=0.05)
    np.testing.assert_allclose(found.log_energy, law.log_energy, rtol=0.05)


@pytest.mark.parametrize(("model", "value"), [("CR", 0.93), ("CDR", 0.03), ("SDR", 0.3)])
def test_losses_are_those_of_the_event_driven_solver(model, value):
    found = losses_by_impact(Damping(model, [value]), 5)[0]
    exact = exact_history(
        blocks.CURVE, Damping(model, value), [20.0], release_amplitude=blocks.RELEASE
    )
    peaks = np.abs(np.concatenate([[blocks.RELEASE], exact.turning_displacement[:5]]))
    np.testing.assert_allclose(found, -0.5 * np.diff(np.log(blocks.CURVE.energy(peaks))), atol=3e-4)


def test_a_decay_that_ends_has_lost_all():
    assert losses_by_impact(Damping("SDR", [3.0]), 4)[0, -1] == blocks.LARGEST_LOSS


def test_shipped_deviation_is_that_of_the_built_trials():
    try:
        study = dataset.read(ROOT / "results/measured_rocking.nc")
    except FileNotFoundError:
        pytest.skip("the full results are not built")
    whole = np.hypot(float(study["deviation_within"]), float(study["deviation_between"]))
    assert whole == pytest.approx(BLOCK_RESTITUTION_DEVIATION, abs=0.001)
    assert round(float(study["restitution_over_housner_mean"]), 2) == 0.99

"""Measured trials of blocks: their file, and the prediction of each damper for a block."""

import numpy as np
import pytest
from repository import ROOT

from rockdamp.constants import BLOCK_RESTITUTION_DEVIATION
from rockdamp.errors import InputError
from rockdamp.laboratory import trials as trials_module
from rockdamp.laboratory.trials import (
    BLOCK_CURVE,
    BLOCK_RELEASE,
    RESTING_LOSS,
    TRIAL_COLUMNS,
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

ROWS = [
    "1,1,,0.05,0.2,0.1,3.0,1,0.95",
    "1,1,,0.05,0.2,0.1,3.0,2,0.90",
    "2,1,,0.05,0.3,0.1,4.0,1,0.97",
]
DUPLICATE = ["1,2,1,0.05,0.2,0.1,3.0,1,0.95", "1,2,1,0.05,0.2,0.1,3.0,2,0.90"]
LOSS = np.array([0.01, 0.03, 0.08])


@pytest.fixture
def read(tmp_path):
    def read_rows(rows, columns=TRIAL_COLUMNS):
        lines = ["# synthetic: no", ",".join(columns), *rows, ""]
        (tmp_path / "trials.csv").write_text("\n".join(lines), encoding="utf-8")
        return read_rocking_trials(tmp_path / "trials.csv")

    return read_rows


# --- file -----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def measured_rows():
    return read_rocking_trials(ROOT / "data/measured/limestone-free-rocking.csv")


@pytest.fixture(scope="module")
def measured(measured_rows):
    return make_trials(measured_rows, measured_rows["impact"].max())


def test_shipped_file_has_the_published_trials(measured_rows, measured):
    assert len(measured_rows) == 7545
    assert measured.ratio.shape[0] == measured.geometry.size == 134


def test_losses_of_blocks_are_those_of_housner(measured):
    sine = 1 / np.hypot(1, 1 / np.arange(4, 16))
    np.testing.assert_allclose(measured.housner, -np.log(1.5 * sine**2 - 0.5), rtol=1e-12)


def test_trials_with_the_most_impacts_stand_first(measured):
    counts = np.isfinite(measured.ratio).sum(axis=1)
    assert (np.diff(counts) <= 0).all()
    assert counts.sum() == 7545 - 26  # the duplicate has 26


def test_duplicate_is_left_out(read):
    trials = make_trials(read([*DUPLICATE, *ROWS]), 2)
    np.testing.assert_array_equal(trials.ratio, [[0.95, 0.90], [0.97, np.nan]])
    assert trials.geometry.tolist() == [0, 1]


def test_only_the_first_impacts_are_taken(read):
    assert make_trials(read(ROWS), 1).ratio.tolist() == [[0.95], [0.97]]


@pytest.mark.parametrize(
    ("rows", "columns", "named"),
    [
        pytest.param(ROWS, TRIAL_COLUMNS[:-1], "columns", id="missing column"),
        pytest.param(
            [ROWS[0], ROWS[2], ROWS[1].replace(",2,0.90", ",3,0.90")],
            TRIAL_COLUMNS,
            "trial 1 of group 1",
            id="missing impact",
        ),
        pytest.param([ROWS[0].replace("0.95", "nan")], TRIAL_COLUMNS, "row 1", id="no number"),
        pytest.param(
            [*ROWS, ROWS[2].replace("2,1,,0.05", "2,2,,0.06")],
            TRIAL_COLUMNS,
            "group 2",
            id="two sizes",
        ),
    ],
)
def test_invalid_table_is_refused(read, rows, columns, named):
    with pytest.raises(InputError, match=f"trials.csv: .*{named}"):
        read(rows, columns)


# --- predictions ----------------------------------------------------------------------------------


def test_power_zero_is_one_ratio():
    ratio, log_energy = power_law(LOSS, 0.0, 5)
    np.testing.assert_allclose(ratio, np.exp(-np.broadcast_to(LOSS, (5, 3))), rtol=1e-14)
    np.testing.assert_allclose(log_energy, -2 * np.arange(5)[:, None] * LOSS, rtol=1e-12)


def test_power_law_loses_by_the_remaining_energy():
    ratio, log_energy = power_law(LOSS, 0.5, 5)
    np.testing.assert_allclose(-np.log(ratio), LOSS * np.exp(0.5 * log_energy), rtol=1e-12)
    np.testing.assert_allclose(np.diff(log_energy, axis=0), 2 * np.log(ratio[:-1]), rtol=1e-12)


@pytest.mark.parametrize("model", ["CR", "ECD", "BAND"])
def test_amplitude_independent_dampers_have_one_ratio(model):
    ratio = predict_damper(model, 8)(LOSS, 0.0).ratio
    np.testing.assert_allclose(np.log(ratio), -np.broadcast_to(LOSS, (8, 3)), atol=3e-4)


@pytest.mark.parametrize(("model", "exponent"), [("CDC", 0.5), ("CDR", 0.0), ("SDR", -0.5)])
def test_dampers_of_the_paper_follow_a_power_law(model, exponent, monkeypatch):
    """To first order in the loss, on a rigid block from a small release."""
    monkeypatch.setattr(trials_module, "BLOCK_CURVE", TrilinearCurve(0.002, 0.996))
    monkeypatch.setattr(trials_module, "BLOCK_RELEASE", 0.1)
    loss = np.array([0.002, 0.004])
    damper = predict_damper(model, 6)(loss, 0.0)
    law = power_law(loss, exponent, 6)
    np.testing.assert_allclose(np.log(damper.ratio) / np.log(law.ratio), 1.0, atol=0.05)
    np.testing.assert_allclose(damper.log_energy, law.log_energy, rtol=0.05)


@pytest.mark.parametrize(("model", "value"), [("CR", 0.93), ("CDR", 0.03), ("SDR", 0.3)])
def test_losses_are_those_of_the_event_driven_solver(model, value):
    losses = losses_by_impact(Damping(model, [value]), 5)[0]
    damping = Damping(model, value)
    exact = exact_history(BLOCK_CURVE, damping, [20.0], release_amplitude=BLOCK_RELEASE)
    peaks = np.abs([BLOCK_RELEASE, *exact.turning_displacement[:5]])
    expected = -0.5 * np.diff(np.log(BLOCK_CURVE.energy(peaks)))
    np.testing.assert_allclose(losses, expected, atol=3e-4)


def test_decay_without_another_turn_has_lost_all():
    assert losses_by_impact(Damping("SDR", [3.0]), 4)[0, -1] == RESTING_LOSS


# --- shipped constant -----------------------------------------------------------------------------


@pytest.fixture
def built():
    try:
        return dataset.read(ROOT / "results/measured_rocking.nc")
    except FileNotFoundError:
        pytest.skip("the full results are not built")


def test_shipped_deviation_is_that_of_the_trials(built):
    deviation = np.hypot(float(built["deviation_within"]), float(built["deviation_between"]))
    assert deviation == pytest.approx(BLOCK_RESTITUTION_DEVIATION, abs=0.001)


def test_trials_lie_just_below_housner(built):
    assert round(float(built["restitution_over_housner_mean"]), 2) == 0.99

"""Measured trials of blocks: their file, and what each damper predicts for a block."""

import numpy as np
import pytest
from repository import ROOT

from rockdamp.constants import BLOCK_RESTITUTION_DEVIATION
from rockdamp.errors import InputError
from rockdamp.laboratory import trials as blocks
from rockdamp.laboratory.trials import DamperLosses, losses_by_impact, power_law, read_rocking_trials
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset

FILE = ROOT / "data/measured/limestone-free-rocking.csv"
COLUMNS = "# synthetic: no\ngroup,trial,duplicate_of_trial,thickness_m,height_m,depth_m,mass_kg,impact,ratio\n"
ROWS = ["1,1,,0.05,0.2,0.1,3.0,1,0.95", "1,1,,0.05,0.2,0.1,3.0,2,0.90", "2,1,,0.05,0.3,0.1,4.0,1,0.97"]
COPY = ["1,2,1,0.05,0.2,0.1,3.0,1,0.95", "1,2,1,0.05,0.2,0.1,3.0,2,0.90"]
LOSS = np.array([0.01, 0.03, 0.08])


def written(folder, rows, columns=COLUMNS):
    (folder / "trials.csv").write_text(columns + "\n".join(rows) + "\n", encoding="utf-8")
    return folder / "trials.csv"


def test_the_measured_trials_are_those_that_their_header_describes():
    trials = read_rocking_trials(FILE)
    assert (trials.impacts, trials.trials, trials.duplicates) == (7545, 135, 1)
    assert trials.ratio.shape[0] == trials.geometry.size == 134
    np.testing.assert_allclose(trials.height / trials.thickness, np.arange(4, 16))
    counts = np.isfinite(trials.ratio).sum(axis=1)
    assert (np.diff(counts) <= 0).all() and counts.sum() == 7545 - 26  # those of the duplicate


def test_a_trial_s_duplicate_is_left_out(tmp_path):
    trials = read_rocking_trials(written(tmp_path, [*ROWS, *COPY]))
    np.testing.assert_array_equal(trials.ratio, [[0.95, 0.90], [0.97, np.nan]])
    assert trials.geometry.tolist() == [0, 1] and trials.duplicates == 1


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"columns": COLUMNS.replace(",ratio", "")}, "columns"),
        ({"rows": [ROWS[0], ROWS[2], ROWS[1].replace(",2,0.90", ",3,0.90")]}, "trial 1 of group 1"),
        ({"rows": [ROWS[0].replace("0.95", "nan")]}, "row 1"),
        ({"rows": [*ROWS, ROWS[2].replace("2,1,,0.05", "2,2,,0.06")]}, "group 2"),
    ],
)
def test_what_is_not_whole_is_refused(tmp_path, change, named):
    with pytest.raises(InputError, match=named) as error:
        read_rocking_trials(written(tmp_path, **{"rows": ROWS, **change}))
    assert "trials.csv" in str(error.value)


# --- predictions ------------------------------------------------------------------------------------------------------


def test_the_power_law_with_exponent_0_is_a_geometric_decay_and_others_follow_the_energy():
    ratio, log_energy = power_law(LOSS, 0.0, 5)
    np.testing.assert_allclose(ratio, np.exp(-np.broadcast_to(LOSS, (5, 3))), rtol=1e-14)
    np.testing.assert_allclose(log_energy, -2 * np.arange(5)[:, None] * LOSS, rtol=1e-12)
    ratio, log_energy = power_law(LOSS, 0.5, 5)
    np.testing.assert_allclose(-np.log(ratio), LOSS * np.exp(0.5 * log_energy), rtol=1e-12)
    np.testing.assert_allclose(np.diff(log_energy, axis=0), 2 * np.log(ratio[:-1]), rtol=1e-12)


@pytest.mark.parametrize("model", ["CR", "ECD", "BAND"])
def test_what_loses_the_same_at_any_amplitude_predicts_one_ratio(model):
    ratio = DamperLosses(model, 8)(LOSS).ratio
    np.testing.assert_allclose(np.log(ratio), -np.broadcast_to(LOSS, (8, 3)), atol=3e-4)


@pytest.mark.parametrize(("model", "exponent"), [("CDC", 0.5), ("CDR", 0.0), ("SDR", -0.5)])
def test_the_paper_s_dampers_follow_their_power_law_to_first_order_in_the_loss(model, exponent, monkeypatch):
    """On a rigid block from a small release, where the force hardly changes."""
    monkeypatch.setattr(blocks, "CURVE", TrilinearCurve(0.002, 0.996))
    monkeypatch.setattr(blocks, "RELEASE", 0.1)
    loss = np.array([0.002, 0.004])
    found, law = DamperLosses(model, 6)(loss), power_law(loss, exponent, 6)
    np.testing.assert_allclose(np.log(found.ratio) / np.log(law.ratio), 1.0, atol=0.05)
    np.testing.assert_allclose(found.log_energy, law.log_energy, rtol=0.05)


@pytest.mark.parametrize(("model", "value"), [("CR", 0.93), ("CDR", 0.03), ("SDR", 0.3)])
def test_the_losses_are_those_of_the_event_driven_solver(model, value):
    found = losses_by_impact(Damping(model, [value]), 5)[0]
    exact = exact_history(blocks.CURVE, Damping(model, value), [20.0], release_amplitude=blocks.RELEASE)
    peaks = np.abs(np.concatenate([[blocks.RELEASE], exact.turning_displacement[:5]]))
    np.testing.assert_allclose(found, -0.5 * np.diff(np.log(blocks.CURVE.energy(peaks))), atol=3e-4)


def test_a_decay_that_ends_has_lost_all():
    assert losses_by_impact(Damping("SDR", [3.0]), 4)[0, -1] == blocks.LARGEST_LOSS


def test_the_spread_that_the_package_ships_is_that_of_the_built_trials():
    try:
        study = dataset.read(ROOT / "results/measured_rocking.nc")
    except FileNotFoundError:
        pytest.skip("the full results are not built")
    whole = np.hypot(float(study["deviation_within"]), float(study["deviation_between"]))
    assert whole == pytest.approx(BLOCK_RESTITUTION_DEVIATION, abs=0.001)
    assert round(float(study["restitution_over_housner_mean"]), 2) == 0.99

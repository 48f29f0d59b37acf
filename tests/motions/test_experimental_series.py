"""The test series of experimental-style records: its walls, and the records that are shipped."""

import csv
from dataclasses import replace

import experimental_series as series
import numpy as np
import pytest
from experimental_series import DURATION, Maker
from experimental_style import SAMPLING, WALL
from repository import ROOT
from rounded_texts import assert_shipped

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.records import read_record, write_record
from rockdamp.solvers import event_driven
from rockdamp.storage import yaml_file
from rockdamp.vocabulary import STANDARD_GRAVITY

FOLDER = ROOT / "data" / "test_series"
SETTINGS = yaml_file.load((FOLDER / "test_series.yaml").read_text(encoding="utf-8"))
LEVELS, WALLS, PULSE = SETTINGS["levels"], SETTINGS["walls"], SETTINGS["pulse"]
NAMES = [f"{wall}-{level}" for wall in WALLS for level in LEVELS]
ELAPSED = np.arange(int(DURATION * SAMPLING) + 1) / SAMPLING
U_INS, P = float(WALL.instability_displacement), float(WALL.frequency_parameter)


def maker(wall, **changed):
    given = {"restitution": SETTINGS["restitution"], **WALLS[wall], **changed}
    return Maker(TrilinearCurve(**SETTINGS["curve"]), **given)


# --- the walls


def test_a_wall_that_hardly_degrades_moves_as_one_that_does_not():
    """Degrading, it is solved impact by impact: what is handed on from one piece to the next is the whole state."""
    pulse = {**PULSE, "amplitude": LEVELS["quarter"] * STANDARD_GRAVITY}
    times = ELAPSED[ELAPSED < 1.2]
    whole, pieces = (maker("cr", **given).displacement(times, **pulse) for given in ({}, {"growth": 1e-13}))
    np.testing.assert_allclose(pieces, whole, atol=1e-5)  # the pieces sample the smooth load elsewhere
    assert np.abs(whole).max() > 0.2


def test_a_wall_degrades_at_the_impact_that_ends_a_half_cycle_beyond_u1_and_at_no_other():
    curve = maker("cr").curve  # u1 = 0.0305 u_ins
    history = event_driven.history(curve, Damping.cr(0.5), np.linspace(0, 20, 9), release_amplitude=0.3)
    turns = np.abs(history.turning_displacement)
    assert turns[1] > 0.0305 > turns[2]  # the decay leaves the plateau after its second turn
    for last, expected in ((0, 1), (1, 2)):  # of the turns before, and the impact that counts
        seen = replace(history, turning_tau=history.turning_tau[last:], turning_displacement=-turns[last:])
        assert Maker._damaging_impact(seen, curve) == history.impacts[expected]
    slow = replace(history, turning_tau=history.turning_tau[2:], turning_displacement=turns[2:])
    assert Maker._damaging_impact(slow, curve) is None


# --- the records


@pytest.mark.parametrize("name", [NAMES[0], "ecd-quarter", *NAMES[8:]])
def test_a_shipped_record_is_what_the_generator_makes(name, tmp_path):
    wall, _, level = name.partition("-")
    write_record(tmp_path / "made.csv", series.record(SETTINGS, wall, level, SETTINGS["seed"] + NAMES.index(name)))
    shipped = (FOLDER / f"{name}.csv").read_text(encoding="utf-8")
    assert_shipped((tmp_path / "made.csv").read_text(encoding="utf-8"), shipped)


def test_every_shipped_record_says_that_it_is_synthetic_whose_it_is_and_what_made_it():
    assert sorted(path.stem for path in FOLDER.glob("*.csv")) == sorted(NAMES)
    for number, name in enumerate(NAMES):
        record, wall = read_record(FOLDER / f"{name}.csv"), WALLS[name.partition("-")[0]]
        assert record.synthetic and record.header["licence"] == "CC0-1.0"
        assert int(record.header["generator_seed"]) == SETTINGS["seed"] + number
        assert record.header["generator_damping_model"] == wall["damping_model"]
        assert float(record.header["generator_restitution"]) == SETTINGS["restitution"]
        assert float(record.header["generator_cracked_stiffness_growth"]) == wall.get("growth", 0)
        assert float(record.header["generator_plateau_loss"]) == wall.get("loss", 0)
    with (ROOT / "data/sources.csv").open(encoding="utf-8", newline="") as file:
        (row,) = [row for row in csv.DictReader(file) if row["file"] == "test_series"]
    assert row["synthetic"] == "yes"

"""The test series of experimental-style records: its walls, and the records that are shipped."""

import csv
from dataclasses import replace

import experimental_series as series
import numpy as np
import pytest
from experimental_series import DURATION, Maker
from experimental_style import OVERSAMPLING, SAMPLING, WALL, instrumented
from repository import ROOT

from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.motions.pulse_shapes import wavelet
from rockdamp.motions.records import read_record, write_record
from rockdamp.solvers import event_driven, newmark
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


def by_the_kernel(wall, peaks, substeps=24):
    """The response of a wall that does not degrade, by the other solver: at the samples, for each peak in g."""
    per_sample = OVERSAMPLING * substeps
    fine = np.arange((ELAPSED.size - 1) * OVERSAMPLING + 1) / (SAMPLING * OVERSAMPLING)
    motion = wavelet(fine - PULSE["centre"], PULSE["frequency"], PULSE["cycles"], STANDARD_GRAVITY)
    return newmark.solve(
        maker(wall).curve,
        maker(wall).damping,
        step=P / (SAMPLING * per_sample),
        steps=substeps * (fine.size - 1),
        substeps=substeps,
        load_factor=float(WALL.load_factor) * np.asarray(peaks),
        ground_acceleration=motion,
        store_every=per_sample,
    )


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


@pytest.mark.parametrize("name", [NAMES[0], "ecd-quarter", *NAMES[12:]])
def test_a_shipped_record_is_exactly_what_the_generator_makes(name, tmp_path):
    wall, _, level = name.partition("-")
    write_record(tmp_path / "made.csv", series.record(SETTINGS, wall, level, SETTINGS["seed"] + NAMES.index(name)))
    assert (tmp_path / "made.csv").read_text(encoding="utf-8") == (FOLDER / f"{name}.csv").read_text(encoding="utf-8")


@pytest.mark.parametrize("wall", ["cr", "ecd", "ecd16"])
def test_a_shipped_record_is_to_the_last_digit_what_the_other_solver_makes(wall):
    responses = by_the_kernel(wall, list(LEVELS.values())).displacement
    for level, response in zip(LEVELS, responses, strict=True):
        name = f"{wall}-{level}"
        shipped = read_record(FOLDER / f"{name}.csv")
        motion = wavelet(
            ELAPSED - PULSE["centre"], PULSE["frequency"], PULSE["cycles"], LEVELS[level] * STANDARD_GRAVITY
        )
        made = instrumented(ELAPSED, motion, U_INS * response, SETTINGS["seed"] + NAMES.index(name), {"source": ""})
        np.testing.assert_array_equal(shipped.ground_acceleration, made.ground_acceleration)
        np.testing.assert_allclose(shipped.displacement, made.displacement, atol=1.001e-5)  # one step of the logger


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


def test_the_levels_are_barely_rocking_a_quarter_half_and_near_nine_tenths():
    for level, low, high in (
        ("barely", 0.04, 0.07),
        ("quarter", 0.23, 0.27),
        ("half", 0.47, 0.53),
        ("nine-tenths", 0.86, 0.93),
    ):
        record = read_record(FOLDER / f"cr-{level}.csv")
        zero = record.displacement[ELAPSED < 0.3].mean()
        assert low < np.abs(record.displacement - zero).max() / U_INS < high

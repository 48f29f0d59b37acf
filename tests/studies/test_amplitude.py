"""The damping ratio against the amplitude: from peaks, from Err, from the closed form."""

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


# --- ratio from peaks -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "curve",
    [PAPER, TrilinearCurve(0.02, 0.85), TrilinearCurve(0.2, 0.5, 0.9, "translated")],
)
def test_ecd_from_peaks_is_exact_at_any_amplitude(curve):
    e = np.array([[0.75], [0.85], [0.95]])
    x0 = np.linspace(0.05, 0.95, 10) * float(curve.ultimate_displacement_ratio)
    ratio = damping_ratio_peaks(curve, "ECD", e, x0)
    expected = Damping.from_restitution(e, "ECD").value
    # The half cycle's steps are good for 4e-4.
    np.testing.assert_allclose(ratio, np.broadcast_to(expected, ratio.shape), rtol=4e-4)


@pytest.mark.parametrize("x0", [0.1, 0.5, 0.9])
@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR"])
def test_ratio_from_peaks_gives_the_peak_of_cr(model, x0):
    """By the event-driven solver."""
    e = 0.8
    damping = Damping(model, float(damping_ratio_peaks(PAPER, model, e, x0)))
    end = 0.8 * float(PAPER.period(x0))
    history = exact_history(PAPER, damping, [end], release_amplitude=x0)
    energy = PAPER.energy(history.turning_displacement[0]) / PAPER.energy(x0)
    assert float(energy) == pytest.approx(e**2, rel=1e-4)


@pytest.mark.parametrize("model", ["CDC", "CDR", "SDR", "ECD"])
def test_dampers_are_equal_on_the_first_branch(model):
    ratio = float(damping_ratio_peaks(PAPER, model, 0.8, 0.035))
    assert ratio == pytest.approx(float(Damping.from_restitution(0.8, "ECD").value), rel=1e-4)


# --- stage ----------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def study():
    """The shipped config with fewer values and a larger step."""
    section = {"release_share": [0.05, 0.5, 0.95]}
    return amplitude(configured({"solver": {"step": 0.01}, "amplitude": section}))


def test_dataset_is_of_its_kind(study):
    dataset.check(study, "amplitude")
    assert study["damping_model"].values.tolist() == ["CDC", "CDR", "SDR", "ECD"]


@pytest.mark.parametrize("name", ["damping_ratio", "damping_ratio_peaks", "damping_ratio_energy"])
def test_every_ratio_is_finite(study, name):
    assert bool(np.isfinite(study[name]).all())


def test_uncertainty_is_small_and_above_the_resolution(study):
    uncertainty = study["damping_ratio_uncertainty"]
    assert (uncertainty < 0.03 * study["damping_ratio"]).all()
    assert (uncertainty >= RESOLUTION * study["damping_ratio"]).all()


@pytest.mark.parametrize(
    ("measure", "model", "e", "low", "high"),
    [
        ("damping_ratio_peaks", "CDR", 0.75, 0, 0.04),
        ("damping_ratio_peaks", "SDR", 0.85, 0, 0.05),
        ("damping_ratio_peaks", "CDC", 0.75, 0.1, 0.21),
        ("damping_ratio", "CDR", 0.75, 0.04, 0.12),
        ("damping_ratio", "SDR", 0.75, 0.02, 0.11),
    ],
)
def test_closed_form_is_within_its_stated_error(study, measure, model, e, low, high):
    """Section 6 of docs/theory.md, on fewer amplitudes: none may exceed the stated largest."""
    values = study.sel(damping_model=model, restitution=e)
    error = float(abs(values["damping_ratio_energy"] / values[measure] - 1).max())
    assert low < error < high

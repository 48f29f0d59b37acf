"""`decay`, `respond` and `calibrate` at the command line: what they print and what they write."""

import numpy as np
import pytest
import xarray as xr
from command_line import printed, refused, run

import rockdamp as rd
from rockdamp.laboratory import calibration
from rockdamp.storage import dataset

CURVE = ("--a1", 0.04, "--b1", 0.8)
WALL = ("--thickness", 0.102, "--height", 2.754, "--hinge-ratio", 0.57, "--overburden-ratio", 6.2)
CDR = ("--damping-model", "CDR", "--damping-ratio", 0.05)
MOTION = ["pga", "pgv", "duration", "rocking_onset"]
KEYS = ["peak_displacement", "peak", "peak_elapsed", "outcome", "outcome_elapsed"]


# --- decay ----------------------------------------------------------------------------------------------------------


# --- respond --------------------------------------------------------------------------------------------------------


# --- calibrate ------------------------------------------------------------------------------------------------------


@pytest.fixture
def quick(monkeypatch):
    """A calibration that is there already: what it computes is tested elsewhere."""
    names = ["yield_displacement_ratio", "strength_ratio", "restitution"]
    one, elapsed = np.array([0.03, 0.8, 0.85]), 0.01 * np.arange(5)
    made = xr.Dataset(
        {
            "estimate": ("parameter", one),
            "standard_error": ("parameter", 0.01 * one),
            "true_value": ("parameter", np.array([np.nan, np.nan, np.nan])),
            "covariance": (("parameter", "parameter_other"), np.diag((0.01 * one) ** 2)),
            "interval": (("bound", "parameter"), np.stack([0.9 * one, 1.1 * one])),
            "damping_ratio": np.nan,
            "run_estimate": (("run", "parameter"), one[None]),
            "sample_run": ("sample", np.ones(5, dtype=int)),
            "measured": ("sample", 0.001 * np.arange(5.0)),
            "control_displacement": ("sample", 0.0011 * np.arange(5.0)),
            "residual_rms": 2e-4,
            "residual_over_peak": 0.05,
            "residual_over_noise": 2.0,
            "rest_deviation": 1e-4,
        },
        coords={
            "parameter": names,
            "parameter_other": names,
            "bound": ["low", "high"],
            "run": [1],
            "elapsed": ("sample", elapsed),
        },
        attrs={"record_synthetic": "no", "record_specimen": "a wall"},
    )
    given = {}

    def calibrate(record, wall, **options):
        given.update(record=record, wall=wall, **options)
        return made

    monkeypatch.setattr(calibration, "calibrate", calibrate)
    return given, made


def test_calibrate_prints_and_writes_what_was_fitted(quick, record, tmp_path):
    given, made = quick
    output, plot = tmp_path / "fit.nc", tmp_path / "fit.png"
    arguments = ("calibrate", "--record", record, *WALL, "--a3", 0.9, "--softening", "translated")
    told = printed(*arguments, "--output", output, "--plot", plot)
    rows = told["parameters"]
    assert [told[f"residual_{name}"] for name in ("rms", "over_peak", "over_noise")] == [2e-4, 0.05, 2.0]
    assert [row["parameter"] for row in rows] == list(made["parameter"].values)
    assert [row["estimate"] for row in rows] == list(made["estimate"].values)
    assert [row["standard_error"] for row in rows] == list(made["standard_error"].values)
    assert all(row["true_value"] is None for row in rows)
    assert given["wall"] == rd.Wall(0.102, 2.754, hinge_ratio=0.57, overburden_ratio=6.2)
    assert (given["ultimate_displacement_ratio"], given["softening"]) == (0.9, "translated")
    dataset.check(dataset.read(output), "calibration")
    assert plot.read_bytes().startswith(b"\x89PNG")
    misfit, _, head, *_ = run(*arguments).stdout.splitlines()
    assert misfit == "the best fit leaves 0.2 mm, 5 % of the peak, 2 times the sensor's noise at rest"
    assert head.split() == ["parameter", "estimate", "standard_error", "interval_90"]


def test_a_size_may_have_a_standard_deviation(quick, record):
    given, _ = quick
    for stated in ("110mm±2mm", "0.11+-0.002", "110mm±0.002"):
        printed("calibrate", "--record", record, *WALL[2:], "--thickness", stated)
        assert given["uncertain"] == {"thickness": 0.002} and float(given["wall"].thickness) == 0.11
    for stated in ("0.11±x", "1±1±1"):
        assert "--thickness" in refused("calibrate", "--record", record, *WALL[2:], "--thickness", stated)


# --- bad input ------------------------------------------------------------------------------------------------------


# --- the functions behind it ----------------------------------------------------------------------------------------

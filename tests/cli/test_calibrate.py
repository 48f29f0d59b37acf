"""`calibrate`: records, and tests without ground motion; what is fitted is tested with the laboratory."""

import json

import numpy as np
import pytest
import xarray as xr
from command_line import printed, refused, run
from repository import ROOT

import rockdamp as rd
from rockdamp.laboratory import calibration
from rockdamp.storage import dataset

FIRST, SECOND = (str(ROOT / f"examples/my-free-rocking-{number}.csv") for number in (1, 2))
SHAKEN = str(ROOT / "data/sin-03-00-synthetic.csv")
BLOCK = ("--thickness", "250mm", "--height", "3m", "--hinge-ratio", "0.6")
WALL = ("--thickness", 0.102, "--height", 2.754, "--hinge-ratio", 0.57, "--overburden-ratio", 6.2)


@pytest.fixture
def quick(monkeypatch):
    """A calibration that is there already; what it was given is noted."""
    names, one = ["yield_displacement_ratio", "strength_ratio", "restitution"], np.array([0.03, 0.8, 0.85])
    made = xr.Dataset(
        {
            "estimate": ("parameter", one),
            "standard_error": ("parameter", 0.01 * one),
            "true_value": ("parameter", np.full(3, np.nan)),
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
            "elapsed": ("sample", 0.01 * np.arange(5)),
        },
        attrs={"record_synthetic": "no", "record_specimen": "a wall"},
    )
    given = {}

    def calibrate(records, wall, **options):
        given.update(records=records, wall=wall, **options)
        return made

    monkeypatch.setattr(calibration, "calibrate", calibrate)
    return given


def test_what_was_fitted_is_printed_and_written(quick, tmp_path):
    output, plot = tmp_path / "fit.nc", tmp_path / "fit.png"
    given = ("calibrate", "--record", SHAKEN, "--records", SHAKEN, *WALL, "--a3", 0.9, "--softening", "translated")
    told = printed(*given, "--output", output, "--plot", plot)
    assert [told[f"residual_{name}"] for name in ("rms", "over_peak", "over_noise")] == [2e-4, 0.05, 2.0]
    assert [row["estimate"] for row in told["parameters"]] == [0.03, 0.8, 0.85]
    assert told["parameters"][0]["interval_90"] == pytest.approx([0.027, 0.033])
    assert told["parameters"][0]["true_value"] is None
    assert len(quick["records"]) == 2 and quick["uncertain"] == {}
    assert quick["wall"] == rd.Wall(0.102, 2.754, hinge_ratio=0.57, overburden_ratio=6.2)
    assert (quick["ultimate_displacement_ratio"], quick["softening"]) == (0.9, "translated")
    dataset.check(dataset.read(output), "calibration")
    assert plot.read_bytes().startswith(b"\x89PNG")
    assert "0.2 mm (rms), 5 % of the largest peak, 2 times the noise" in run(*given).stdout


@pytest.mark.parametrize("stated", ["110mm±2mm", "0.11+-0.002", "110mm±0.002"])
def test_a_size_may_have_a_standard_deviation(stated, quick):
    printed("calibrate", "--record", SHAKEN, *WALL[2:], "--thickness", stated)
    assert quick["uncertain"] == {"thickness": 0.002} and float(quick["wall"].thickness) == 0.11


def test_the_releases_of_a_specimen_are_fitted_together(tmp_path):
    output, plot = tmp_path / "fit.nc", tmp_path / "fit.png"
    fit = run("calibrate", "--free-rocking", FIRST, SECOND, *BLOCK, "--output", output, "--plot", plot, "--json")
    assert fit.exit_code == 0, fit.output
    told, true = json.loads(fit.stdout), rd.read_free_rocking(SECOND).header
    for row in told["parameters"]:
        low, high = row["interval_90"]
        assert low < row["estimate"] < high
        assert row["estimate"] == pytest.approx(float(true[f"generator_{row['parameter']}"]), abs=0.01)
    assert len(told["releases"]) == 2 and len(told["impacts"]) == len(told["half_cycles"]) - 2
    assert {row["damping_model"]: row["excluded"] for row in told["damping_models"]}["CDC"]
    assert told["residual_over_rest"] == pytest.approx(1, abs=0.15)
    assert [row["amplitude"] for row in told["restitution_at"]] == [0.1, 0.3, 0.5]
    assert plot.read_bytes().startswith(b"\x89PNG")
    with xr.open_dataset(output) as stored:
        assert stored.sizes["release"] == 2


def test_a_video_has_frames_and_pixels(tmp_path):
    test = rd.read_free_rocking(FIRST)
    rows = np.column_stack([np.arange(test.elapsed.size), test.displacement / 0.00035])
    np.savetxt(tmp_path / "video.csv", rows, delimiter=",", header="frame,x_pixel", comments="")
    rate = 1 / test.elapsed[1]
    given = ("calibrate", "--free-rocking", tmp_path / "video.csv", "--frame-rate", rate, "--pixel", "0.35mm", *BLOCK)
    estimates = [
        [row["estimate"] for row in printed(*each)["parameters"]]
        for each in (given, ("calibrate", "--free-rocking", FIRST, *BLOCK))
    ]
    assert estimates[0] == pytest.approx(estimates[1], rel=1e-6)
    assert "half periods" in refused("calibrate", "--free-rocking", tmp_path / "video.csv", "--pixel", "0.35mm", *BLOCK)


def test_the_table_says_what_the_test_says():
    told, text = (call("calibrate", "--free-rocking", FIRST, *BLOCK) for call in (printed, run))
    e = told["restitution_at"][1]["restitution"]
    assert f"assess --restitution {e:.3f}" in text.stdout and "excluded" in text.stdout
    assert f"{told['restitution_rigid']:.4f}" in text.stdout and "times the noise at rest" in text.stdout


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        ((), "--record FILE"),
        (("--free-rocking",), "--free-rocking FILE"),
        ((SECOND,), "--free-rocking FILE"),
        (("--free-rocking", SECOND, "--record", SHAKEN), "either"),
        (("--free-rocking", SECOND, "--compare"), "--compare"),
        (("--record", SHAKEN, "--least-peak", "2mm"), "--least-peak"),
        (("--free-rocking", SECOND, "--a3", "0.2"), "largest peak"),
        (("--record", "none.csv"), "none.csv"),
        (("--record", SHAKEN, "--thickness", "0.11±x"), "--thickness"),
        (("--record", SHAKEN, "--thickness", "1±1±1"), "--thickness"),
    ],
)
def test_a_mistake_is_one_line(arguments, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = refused("calibrate", *BLOCK, *arguments)
    assert len(said.splitlines()) == 1 and named in said and not list(tmp_path.iterdir())

"""`record --free-rocking` and `calibrate --free-rocking` at the command line, and their pictures."""

import json

import numpy as np
import pytest
import xarray as xr
from command_line import printed, run
from repository import ROOT

import rockdamp as rd
from rockdamp.laboratory.figures import free_rocking_figure

RAW, SECOND = (str(ROOT / f"examples/my-free-rocking-{name}.csv") for name in ("raw", "2"))
WALL = ["--thickness", "250mm", "--height", "3m", "--hinge-ratio", "0.6"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The raw example as a test, and the fit of both examples."""
    folder = tmp_path_factory.mktemp("free")
    test, output, plot = folder / "test.csv", folder / "fit.nc", folder / "fit.png"
    record = run("record", RAW, "--free-rocking", "--time", "t:ms", "--wall", "d:mm", "--synthetic", "--output", test)
    assert record.exit_code == 0, record.output
    fit = run("calibrate", "--free-rocking", test, SECOND, *WALL, "--output", output, "--plot", plot, "--json")
    assert fit.exit_code == 0, fit.output
    return test, json.loads(fit.stdout), output, plot


def test_raw_channels_become_a_test_in_metres(made):
    raw = np.loadtxt(RAW, delimiter=";", skiprows=5)
    test = rd.read_free_rocking(made[0])
    np.testing.assert_allclose(test.displacement, raw[:, 1] / 1000, atol=1e-12)
    np.testing.assert_allclose(test.elapsed, raw[:, 0] / 1000, atol=1e-9)
    assert test.synthetic and test.header["wall_channel"] == "d, times 0.001"


def test_json_holds_parameters_impacts_and_dampers(made):
    _, told, output, plot = made
    a1, b1, e = told["parameters"]
    true = rd.read_free_rocking(SECOND).header
    for row in (a1, b1, e):
        low, high = row["interval_90"]
        assert low < row["estimate"] < high
        assert row["estimate"] == pytest.approx(float(true[f"generator_{row['parameter']}"]), abs=0.01)
    assert len(told["releases"]) == 2 and len(told["impacts"]) == len(told["half_cycles"]) - 2
    assert {row["damping_model"]: row["excluded"] for row in told["damping_models"]}["CDC"]
    assert told["residual_over_rest"] == pytest.approx(1, abs=0.15)
    assert told["restitution_rigid"] == pytest.approx(float(rd.Wall(0.25, 3.0, hinge_ratio=0.6).restitution_rigid))
    assert plot.read_bytes().startswith(b"\x89PNG")
    with xr.open_dataset(output) as stored:
        assert stored.attrs["title"].startswith("Curve, restitution") and stored.sizes["release"] == 2


def test_the_picture_shows_the_test_in_millimetres_its_half_periods_and_e_of_each_impact(made):
    with xr.open_dataset(made[2]) as stored:
        fitted = stored.load()
    figure = free_rocking_figure(fitted)
    figure.draw_without_rendering()
    history, periods, impacts, _ = figure.axes
    first = (fitted["sample_release"] == 1).values
    np.testing.assert_allclose(history.lines[0].get_ydata(), 1000 * fitted["measured"].values[first])
    shown = np.concatenate([line.get_ydata() for line in periods.lines if line.get_linestyle() == "None"])
    np.testing.assert_allclose(np.sort(shown), np.sort(fitted["half_period"].values))
    rocking = (fitted["impact_rocking"] == 1).values
    shown = np.concatenate([container[0].get_ydata() for container in impacts.containers])
    np.testing.assert_allclose(np.sort(shown), np.sort(fitted["impact_restitution"].values[rocking]))
    assert figure.get_suptitle().startswith("SYNTHETIC record")


def test_the_table_says_what_the_test_says(made):
    result = run("calibrate", "--free-rocking", made[0], *WALL)
    assert result.exit_code == 0, result.output
    at = {row["amplitude"]: row for row in printed("calibrate", "--free-rocking", made[0], *WALL)["restitution_at"]}
    assert [*at] == [0.1, 0.3, 0.5] and all(
        low < e["restitution"] < high for e in at.values() for low, high in [e["interval_90"]]
    )
    for words in (
        *(f"{row['restitution']:.3f} ({row['interval_90'][0]:.5g} to" for row in at.values()),
        f"assess --restitution {at[0.3]['restitution']:.3f}",
        "of the analytical 0.9575 (Eq. (7))",
        "times the noise at rest",
        "to the power",
        "excluded",
        "u/u_ins",
    ):
        assert words in result.stdout


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["calibrate", *WALL], "there must be --record FILE, or --free-rocking FILE"),
        (["calibrate", "--free-rocking", *WALL], "must be followed by a file"),
        (["calibrate", SECOND, *WALL], "must follow --record or --free-rocking"),
        (["calibrate", "--free-rocking", SECOND, *WALL, "--posterior"], "--posterior belongs to a record with ground"),
        (["calibrate", "--free-rocking", SECOND, *WALL, "--a3", "0.2"], f"{SECOND}: the largest peak is"),
        (["record", RAW, "--free-rocking", "--time", "t:ms", "--wall", "d:mm", "--rest", "1", "--output", "x.csv"],
         "--rest belongs to a test with ground motion"),
        (["record", RAW, "--time", "t:ms", "--rotation", "d:deg", "--output", "x.csv"], "--rotation belongs to --free"),
        (["record", RAW, "--free-rocking", "--time", "t:ms", "--rotation", "d:mm", "--output", "x.csv"],
         "rotation has the unit 'mm'"),
    ],
)  # fmt: skip
def test_slips_end_in_one_line(arguments, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2 and said in result.stderr and not list(tmp_path.iterdir())

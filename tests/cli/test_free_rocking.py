"""`calibrate --free-rocking` at the command line, and its picture."""

import json

import numpy as np
import pytest
import xarray as xr
from command_line import printed, run
from repository import ROOT

import rockdamp as rd
from rockdamp.figures.commands import free_rocking_figure

FIRST, SECOND = (str(ROOT / f"examples/my-free-rocking-{number}.csv") for number in (1, 2))
WALL = ["--thickness", "250mm", "--height", "3m", "--hinge-ratio", "0.6"]


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """The fit of both examples."""
    folder = tmp_path_factory.mktemp("free")
    output, plot = folder / "fit.nc", folder / "fit.png"
    fit = run("calibrate", "--free-rocking", FIRST, SECOND, *WALL, "--output", output, "--plot", plot, "--json")
    assert fit.exit_code == 0, fit.output
    return json.loads(fit.stdout), output, plot


def test_json_holds_parameters_impacts_and_dampers(made):
    told, output, plot = made
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
    with xr.open_dataset(made[1]) as stored:
        fitted = stored.load()
    figure = free_rocking_figure(fitted)
    figure.draw_without_rendering()
    history, periods, _, impacts = figure.axes
    first = (fitted["sample_release"] == 1).values
    np.testing.assert_allclose(history.lines[0].get_ydata(), 1000 * fitted["measured"].values[first])
    shown = np.concatenate([line.get_ydata() for line in periods.lines if line.get_linestyle() == "None"])
    np.testing.assert_allclose(np.sort(shown), np.sort(fitted["half_period"].values))
    rocking = (fitted["impact_rocking"] == 1).values
    shown = np.concatenate([container[0].get_ydata() for container in impacts.containers])
    np.testing.assert_allclose(np.sort(shown), np.sort(fitted["impact_restitution"].values[rocking]))
    assert figure.get_suptitle().startswith("SYNTHETIC record")


def test_the_table_says_what_the_test_says():
    result = run("calibrate", "--free-rocking", FIRST, *WALL)
    assert result.exit_code == 0, result.output
    at = {row["amplitude"]: row for row in printed("calibrate", "--free-rocking", FIRST, *WALL)["restitution_at"]}
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
        (["calibrate", "--free-rocking", SECOND, *WALL, "--record", "x.csv"], "--record belongs to a record with"),
        (["calibrate", "--free-rocking", SECOND, *WALL, "--a3", "0.2"], f"{SECOND}: largest peak is"),
    ],
)  # fmt: skip
def test_bad_input_ends_in_one_line(arguments, said, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = run(*arguments)
    assert result.exit_code == 2 and said in result.stderr and not list(tmp_path.iterdir())

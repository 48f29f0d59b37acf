"""`calibrate`: records, and tests without ground motion. The fits themselves are tested with the
laboratory.
"""

import numpy as np
import pytest
import xarray as xr
from coarse_scan import coarse_scan
from command_line import printed, run
from repository import ROOT

import rockdamp as rd
from rockdamp.cli.calibrate import _print_fit, _reason_against
from rockdamp.cli.options import MeasuredQuantity
from rockdamp.storage import dataset

FIRST = str(ROOT / "examples/my-free-rocking-1.csv")
SECOND = str(ROOT / "examples/my-free-rocking-2.csv")
SHAKEN = str(ROOT / "data/sin-03-00-synthetic.csv")
BLOCK = ("--thickness", "250mm", "--height", "3m", "--hinge-ratio", "0.6")
WALL = "--thickness 102mm±1mm --height 2.754 --hinge-ratio 0.57 --overburden-ratio 6.2".split()


def save_options(folder):
    return "--output", folder / "fit.nc", "--plot", folder / "fit.png"


# --- records -----------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    """Every other sample of the first 1.6 s of a record, and a coarse scan, for speed."""
    folder = tmp_path_factory.mktemp("shaken")
    whole = rd.read_record(ROOT / "tests/data/cr-half.csv")
    columns = (whole.elapsed, whole.ground_acceleration, whole.displacement)
    short = rd.Record(*(column[:410:2] for column in columns), whole.header)
    rd.write_record(folder / "short.csv", short)
    curve = ("--a3", 0.95, "--softening", "translated")
    options = (*WALL, *curve, "--compare", *save_options(folder))
    with coarse_scan():
        yield printed("calibrate", "--record", folder / "short.csv", *options), folder


def test_record_has_the_fit_of_the_package(shaken):
    values, folder = shaken
    wall = rd.Wall(0.102, 2.754, hinge_ratio=0.57, overburden_ratio=6.2)
    curve = {"ultimate_displacement_ratio": 0.95, "softening": "translated"}
    fit = rd.calibrate(
        rd.read_record(folder / "short.csv"), wall, **curve, uncertain={"thickness": 0.001}
    )
    for name in ("estimate", "standard_error", "true_value"):
        assert [row[name] for row in values["parameters"]] == fit[name].values.tolist()
    intervals = [row["interval_90"] for row in values["parameters"]]
    assert intervals == fit["interval"].T.values.tolist()
    for name in ("residual_rms", "residual_over_peak", "residual_over_noise"):
        assert values[name] == fit[name].item()


def test_compare_fits_every_damper(shaken):
    values, _ = shaken
    cr = values["damping_models"][0]
    estimates = {row["parameter"]: row["estimate"] for row in values["parameters"]}
    assert {name: cr[name] for name in estimates} == pytest.approx(estimates, rel=1e-12)
    assert sum(row["weight"] for row in values["damping_models"]) == pytest.approx(1)


def test_fit_of_a_record_is_saved(shaken):
    _, folder = shaken
    dataset.check(dataset.read(folder / "fit.nc"), "calibration")
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("text", ["110mm±2mm", "0.11+-0.002", "110mm±0.002"])
def test_size_may_have_a_standard_deviation(text):
    size = MeasuredQuantity("m").convert(text, None, None)
    assert (size, size.deviation) == (0.11, 0.002)


def test_size_without_a_deviation_is_exact():
    assert MeasuredQuantity("m").convert("0.1", None, None).deviation == 0


# --- free-rocking tests ------------------------------------------------------------------------


@pytest.fixture(scope="module")
def released(tmp_path_factory):
    folder = tmp_path_factory.mktemp("released")
    options = (*BLOCK, *save_options(folder))
    return printed("calibrate", "--free-rocking", FIRST, SECOND, *options), folder


def test_releases_of_a_specimen_are_fitted_together(released):
    values, _ = released
    header = rd.read_free_rocking(SECOND).header
    for row in values["parameters"]:
        low, high = row["interval_90"]
        assert low < row["estimate"] < high
        true_value = float(header[f"generator_{row['parameter']}"])
        assert row["estimate"] == pytest.approx(true_value, abs=0.01)
    assert len(values["releases"]) == 2
    assert len(values["impacts"]) == len(values["half_cycles"]) - 2
    assert values["residual_over_rest"] == pytest.approx(1, abs=0.15)
    assert [row["amplitude"] for row in values["restitution_at"]] == [0.1, 0.3, 0.5]


def test_bad_fit_gives_no_restitution(released, monkeypatch):
    _, folder = released
    fitted = dataset.read(folder / "fit.nc")
    bad = fitted.assign(residual_rms=20 * fitted["residual_rms"])
    monkeypatch.setattr(rd, "fit_free_rocking", lambda *_, **__: bad)
    text = run("calibrate", "--free-rocking", FIRST, SECOND, *BLOCK).stdout
    assert "times the noise): do not use this e" in text
    assert "use --restitution" not in text


def test_wide_interval_gives_no_restitution(released):
    values, _ = released
    assert not _reason_against(values)
    wide = {"parameter": "restitution", "interval_90": [0.65, 1.3]}
    assert "extends beyond 1" in _reason_against(values | {"parameters": [wide]})


@pytest.fixture(scope="module")
def released_text(released):
    """The printed lines, of the stored fit."""
    fitted = dataset.read(released[1] / "fit.nc")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rd, "fit_free_rocking", lambda *_, **__: fitted)
        return run("calibrate", "--free-rocking", FIRST, SECOND, *BLOCK).stdout


def test_columns_of_each_test_are_stated(released_text):
    first, second = released_text.splitlines()[:2]
    assert first.startswith("my-free-rocking-1.csv: elapsed_s, displacement_m; 4867 samples")
    assert second.startswith("my-free-rocking-2.csv: elapsed_s, displacement_m; 4725 samples")


def test_impacts_of_several_tests_are_told_apart(released_text, released):
    table = released_text.partition("Restitution of each impact (releases in the order")[2]
    heads, *rows = table.splitlines()[1:13]
    assert heads.split()[:3] == ["release", "time", "[s]"]
    values, _ = released
    rocking = [impact for impact in values["impacts"] if impact["impact_rocking"]]
    expected = [str(impact["impact_release"]) for impact in rocking]
    assert [row.split()[0] for row in rows] == expected[: len(rows)]


def test_likelihoods_say_what_they_are_relative_to(released_text, released):
    threshold = released[0]["log_likelihood_threshold"]
    assert (
        f"(a damper below {threshold:.3g}, the limit of a 90 % interval of one parameter, is excluded):"
        in released_text
    )
    assert "ln L minus the best" in released_text


@pytest.mark.parametrize(("ratio", "is_warned_of"), [(0.3, True), (1.0, False), (np.nan, False)])
def test_motion_at_the_end_of_a_file_is_warned_of(ratio, is_warned_of, released, capsys):
    """A residual far below the noise at rest shows that the wall still moved there."""
    _print_fit(released[0] | {"residual_over_rest": ratio})
    warning = "probably ends before the wall is at rest"
    assert (warning in capsys.readouterr().err) == is_warned_of


def test_test_excludes_the_constant_damper(released):
    values, _ = released
    excluded = {row["damping_model"]: row["excluded"] for row in values["damping_models"]}
    assert excluded["CDC"]


def test_fit_of_releases_is_saved(released):
    values, folder = released
    assert (folder / "fit.png").read_bytes().startswith(b"\x89PNG")
    with xr.open_dataset(folder / "fit.nc") as stored:
        assert stored.sizes["release"] == 2
        for row, number in zip(values["impacts"], stored["impact"], strict=True):
            impact = stored.sel(impact=number)
            assert row["impact_restitution"] == impact["impact_restitution"].item()
            assert row["interval_90"] == impact["impact_restitution_interval"].values.tolist()


def test_video_has_frames_and_pixels(released, tmp_path, monkeypatch):
    measured = rd.read_free_rocking(FIRST)
    frames = np.arange(measured.elapsed.size)
    columns = np.column_stack([frames, measured.displacement / 0.00035])
    video = tmp_path / "video.csv"
    np.savetxt(video, columns, delimiter=",", header="frame,x_pixel", comments="")
    tests = []

    def fit(given_tests, *_, **__):
        tests.extend(given_tests)
        return dataset.read(released[1] / "fit.nc")

    monkeypatch.setattr(rd, "fit_free_rocking", fit)
    units = ("--pixel", "0.35mm", "--frame-rate", 1 / measured.elapsed[1])
    printed("calibrate", "--free-rocking", video, *units, *BLOCK)
    (test,) = tests
    np.testing.assert_allclose(test.elapsed, measured.elapsed, rtol=1e-12)
    np.testing.assert_allclose(test.displacement, measured.displacement, rtol=1e-12)

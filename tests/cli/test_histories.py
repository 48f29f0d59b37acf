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


def respond(record, *arguments):
    return ("respond", "--record", record, *WALL, *CURVE, *arguments)


# --- decay ----------------------------------------------------------------------------------------------------------


def test_decay_gives_the_peak_of_each_half_cycle():
    rows = printed("decay", *CURVE, "--damping-model", "CR", "--restitution", 0.9, "--release", 0.4)
    assert [row["impacts"] for row in rows] == list(range(len(rows)))
    assert rows[0]["peak"] == 0.4 and rows[0]["tau"] == 0.0
    curve = rd.TrilinearCurve(0.04, 0.8)
    energy = curve.energy([row["peak"] for row in rows])
    np.testing.assert_allclose(energy[1:6] / energy[:5], 0.9**2, rtol=1e-3)  # Eq. (8)


@pytest.mark.parametrize(
    ("word", "damping"),
    [
        ("ecd16", rd.Damping.from_restitution(0.85, "ECD", order=16)),
        ("BAND", rd.Damping.from_restitution(0.85, "BAND")),
        ("BAND0.4", rd.Damping.from_restitution(0.85, "BAND", width=0.4)),
    ],
)
def test_a_model_s_word_has_its_order_or_width(word, damping):
    rows = printed("decay", *CURVE, "--damping-model", word, "--restitution", 0.85)
    found = rd.free_decay(rd.TrilinearCurve(0.04, 0.8), damping, length=20.0)
    assert rows[1]["peak"] == pytest.approx(-found["displacement"].min().item(), rel=1e-6)
    assert rows[1]["damping_model"] == damping.label == word.upper()


def test_a_decay_without_a_half_cycle_says_so():
    result = run("decay", *CURVE, *CDR, "--length", 0.1)
    assert result.exit_code == 0 and result.stdout == "" and "no half cycle" in result.stderr
    assert printed("decay", *CURVE, *CDR, "--length", 0.1) == []


# --- respond --------------------------------------------------------------------------------------------------------


def test_respond_gives_the_agreed_keys_and_the_packages_numbers(record):
    values = printed(*respond(record, *CDR, "--scale", 2, "--tail", 1))
    assert list(values) == [*KEYS, *MOTION]
    wall = rd.Wall(0.102, 2.754, hinge_ratio=0.57, overburden_ratio=6.2)
    found = rd.respond(
        wall, rd.TrilinearCurve(0.04, 0.8), rd.Damping("CDR", 0.05), rd.read_record(record), scale=2, tail=1
    )
    for key in KEYS[:3]:
        assert values[key] == found[key].item()
    assert values["peak"] == pytest.approx(values["peak_displacement"] / wall.instability_displacement)
    assert values["outcome"] == "completed"
    assert values["outcome_elapsed"] == pytest.approx(0.99 + 1.0)


def test_a_comparison_has_a_row_for_each_model(record):
    arguments = respond(record, "--compare", "--restitution", 0.85)
    rows = printed(*arguments)
    matched = {row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(0.85, rd.TrilinearCurve(0.04, 0.8))}
    assert {row["damping_model"]: row["damping_ratio"] for row in rows} == {"CR": None, **matched}
    alone = printed(*respond(record, "--damping-model", "CR", "--restitution", 0.85))
    assert {key: rows[0][key] for key in (*KEYS, *MOTION)} == alone
    motion, table = run(*arguments).stdout.split("\n\n")
    assert [line.split()[0] for line in motion.splitlines()] == MOTION
    assert table.splitlines()[0].split() == ["damping_model", "damping_ratio", *KEYS]


def test_histories_are_written_with_units_and_origin(record, tmp_path):
    path = tmp_path / "history.nc"
    path.write_text("an earlier file, which is replaced", encoding="utf-8")
    for kind, arguments in (
        ("free_decay", ("decay", *CURVE, *CDR, *WALL)),
        ("response", respond(record, *CDR, "--tail", "500ms")),
    ):
        assert "history.nc written" in run(*arguments, "--output", path).stderr
        found = dataset.read(path)
        dataset.check(found, kind)
        assert {"title", "source", "references", "Conventions", "config", "code_version"} <= set(found.attrs)
        assert all(variable.attrs["units"] and variable.attrs["long_name"] for variable in found.variables.values())
    assert found.attrs["record_synthetic"] == "yes"
    assert found.sizes == {"damping_model": 1, "elapsed": 150}
    assert [file.name for file in sorted(tmp_path.iterdir())] == ["history.nc", "pulse.csv"]


def test_the_digest_of_the_options_follows_the_record_and_not_its_place(record, tmp_path):
    def digest(name, *more):
        run(*respond(tmp_path / name, *CDR, "--output", tmp_path / "out.nc", *more))
        return dataset.read(tmp_path / "out.nc").attrs["config"]

    (tmp_path / "copy.csv").write_bytes(record.read_bytes())
    assert digest("copy.csv") == digest("pulse.csv")
    assert digest("copy.csv", "--scale", 2) != digest("pulse.csv")
    (tmp_path / "copy.csv").write_bytes(record.read_bytes() + b"1.0,0.0\n")
    assert digest("copy.csv") != digest("pulse.csv")


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
            "standard_error_by_motion": ("parameter", 0.005 * one),
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


@pytest.mark.parametrize(
    "arguments, named",
    [
        ((), "--damping-model is missing"),
        (("--damping-model", "CDR"), "--damping-ratio is missing; --damping-model CDR must have it"),
        (("--damping-model", "CR"), "--restitution is missing; --damping-model CR must have it"),
        (("--damping-model", "CR", "--restitution", 0.9, "--damping-ratio", 0.1), "belongs to viscous models"),
        (("--damping-model", "SDR", "--restitution", 0.9, "--damping-ratio", 0.1), "belongs to CR, ECD, BAND;"),
        (("--compare", *CDR, "--restitution", 0.9), "--compare finds every model's damping ratio"),
        (("--compare",), "--restitution is missing; --compare must have it"),
        ((*CDR, "--output", "no/such/folder.nc"), "which is no folder"),
        ((*CDR, "--output", "response.txt"), "must end in .nc"),
        ((*CDR, "--plot", "plot.jpeg"), "must end in .png or .pdf or .svg"),
        ((*CDR, "--output", "folder.nc"), "is a folder"),
    ],
)
def test_bad_input_is_named_and_nothing_is_written(arguments, named, record, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "folder.nc").mkdir()
    before = sorted(tmp_path.rglob("*"))
    assert named in refused(*respond(record, *arguments, *(() if "--output" in arguments else ("--output", "out.nc"))))
    assert sorted(tmp_path.rglob("*")) == before


@pytest.mark.parametrize(
    "arguments, named",
    [
        (("--length", "5s"), "--length in seconds needs --thickness and --height"),
        (("--thickness", 0.3), "--thickness and --height must be given together"),
        (("--parapet",), "--parapet must be given with --thickness and --height"),
    ],
)
def test_bad_input_of_a_decay_is_named(arguments, named):
    assert named in refused("decay", *CURVE, *CDR, *arguments)


@pytest.mark.parametrize("content", [None, "", "elapsed_s\n0\n", "\xff\xfe"])
@pytest.mark.parametrize("command", ["respond", "calibrate"])
def test_a_record_that_cannot_be_read_is_named(command, content, tmp_path):
    path = tmp_path / "bad.csv"
    if content is not None:
        path.write_bytes(content.encode("latin-1"))
    arguments = (command, "--record", path, *WALL)
    assert str(path) in refused(*(respond(path, *CDR) if command == "respond" else arguments))


# --- the functions behind it ----------------------------------------------------------------------------------------


def test_a_decay_of_a_wall_is_in_seconds_and_metres_too():
    plain = printed("decay", *CURVE, *CDR, "--length", 10)
    wall = rd.Wall(0.3, 4.5)
    seconds = 10 / float(wall.frequency_parameter)
    rows = printed("decay", *CURVE, *CDR, "--length", f"{seconds!r}s", "--thickness", "30cm", "--height", 4.5)
    for ours, theirs in zip(rows, plain, strict=True):
        assert ours["peak"] == pytest.approx(theirs["peak"], rel=1e-9)
        assert ours["elapsed"] == pytest.approx(theirs["tau"] / wall.frequency_parameter)
        assert ours["peak_displacement"] == pytest.approx(theirs["peak"] * wall.instability_displacement)


def test_a_file_to_write_is_not_the_record_by_another_name(record, tmp_path):
    path = tmp_path / "linked.nc"
    path.symlink_to(record)
    said = refused(*respond(record, *CDR, "--output", path))
    assert f"--output is '{path}', which --record reads; it must be another file" in said

"""`record` at the command line, and the picture of a record."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from repository import ROOT

import rockdamp as rd
from rockdamp.cli import main
from rockdamp.laboratory.figures import record_figure

RAW = str(ROOT / "examples/my-test-raw.csv")
CHANNELS = ["--time", "t", "--table-acceleration", "a:g", "--wall", "d1:mm", "--table", "d2:mm"]


def test_raw_channels_become_a_record_and_a_picture(tmp_path):
    output, plot = tmp_path / "made.csv", tmp_path / "made.png"
    result = CliRunner().invoke(
        main, ["record", RAW, *CHANNELS, "--output", str(output), "--plot", str(plot), "--json"]
    )
    assert result.exit_code == 0, result.output
    told, made = json.loads(result.stdout), rd.read_record(output)
    assert told["samples"] == made.elapsed.size
    assert told["peak_displacement"] == float(np.abs(made.displacement).max())
    assert told["displacement_offset_removed"] == float(made.header["zero_removed_m"])
    assert not result.stderr.count("not at rest")
    assert plot.read_bytes().startswith(b"\x89PNG")
    ground, moved = record_figure(made).axes
    np.testing.assert_allclose(moved.lines[0].get_ydata(), 1000 * made.displacement)
    assert record_figure(made).get_suptitle() == "Record: not stated"
    assert ground.lines[0].get_ydata().max() == made.ground_acceleration.max()


def test_a_channel_that_is_not_there_is_named_with_its_file(tmp_path):
    output = tmp_path / "made.csv"
    result = CliRunner().invoke(
        main, ["record", RAW, "--time", "t", "--table-velocity", "v:m/s", "--output", str(output)]
    )
    assert result.exit_code == 2 and not output.exists()
    assert f"{RAW}: column 'v' is not there; it must be one of t, a, d1, d2" in result.stderr


@pytest.mark.parametrize("rest", ["1.55", "3", "4.5"])  # of 5 s: no other part is as long as the last two
def test_of_a_record_without_rest_nothing_is_subtracted_and_who_knows_it_hears_nothing(tmp_path, rest):
    """The motion lies in the first 1.55 s, whose means are no zeros."""
    output = str(tmp_path / "made.csv")
    result = CliRunner().invoke(main, ["record", RAW, *CHANNELS, "--rest", rest, "--output", output])
    assert result.exit_code == 0
    doubts = [line for line in result.stderr.splitlines() if line.startswith("warning:")]
    assert len(doubts) == 2 and all(f"the first {rest} s are not at rest" in doubt for doubt in doubts)
    as_measured = rd.read_record(output)
    assert not {"acceleration_offset_removed_m_s2", "zero_removed_m"} & set(as_measured.header)
    for known in (["--rest", rest, "--baseline", "none"], ["--rest", "0s"]):
        result = CliRunner().invoke(main, ["record", RAW, *CHANNELS, *known, "--output", output])
        assert result.exit_code == 0 and "warning" not in result.stderr
        found = rd.read_record(output)
        np.testing.assert_array_equal(found.ground_acceleration, as_measured.ground_acceleration)
        np.testing.assert_array_equal(found.displacement, as_measured.displacement)


def test_what_was_subtracted_is_printed(tmp_path):
    output = str(tmp_path / "made.csv")
    result = CliRunner().invoke(main, ["record", RAW, *CHANNELS, "--rest", "0.2", "--output", output])
    header = rd.read_record(output).header
    removed = (
        f"{float(header['acceleration_offset_removed_m_s2']):.5g}",
        f"{1000 * float(header['zero_removed_m']):.5g}",
    )
    for text, unit in zip(removed, ("m s-2", "mm"), strict=True):
        assert f"{text} {unit}" in result.stdout


def test_a_video_becomes_a_free_rocking_test_and_says_what_was_filled(tmp_path):
    elapsed = np.arange(300) / 30
    rows = [f"{frame},{'' if frame == 50 else 100 * np.cos(elapsed[frame])}" for frame in range(300)]
    (tmp_path / "track.csv").write_text("\n".join(["frame,x", *rows]) + "\n", encoding="utf-8")
    video = ["record", str(tmp_path / "track.csv"), "--free-rocking", "--wall", "x:px", "--synthetic"]
    made = ["--output", str(tmp_path / "made.csv"), "--json"]
    result = CliRunner().invoke(main, [*video, "--frame-rate", "30", "--scale", "0.35mm/px", *made])
    assert result.exit_code == 0, result.output
    told = json.loads(result.stdout)
    assert told["samples"] == 300 and told["samples_filled"] == 1
    assert abs(told["highest_displacement"] - 0.035) < 1e-9
    for wrong, words in (
        (["--frame-rate", "30", "--scale", "0.35mm"], "no size of a pixel; it must be a length for each pixel"),
        (["--scale", "0.35mm/px"], "--time is missing; a video's --frame-rate"),
    ):
        result = CliRunner().invoke(main, [*video, *wrong, *made])
        assert result.exit_code == 2 and words in result.stderr

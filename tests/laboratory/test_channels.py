"""Raw channels of a laboratory become a record, and its header says how."""

from contextlib import nullcontext

import numpy as np
import pytest
import raw_channels
from experimental_style import synthetic_record
from repository import ROOT
from rounded_texts import assert_shipped
from scipy.interpolate import CubicSpline

from rockdamp.errors import InputError, InputWarning
from rockdamp.laboratory.channels import Channel, laboratory_free_rocking, laboratory_record, read_raw
from rockdamp.motions.records import read_record, write_record
from rockdamp.vocabulary import STANDARD_GRAVITY

RAW = ROOT / "examples/my-test-raw.csv"
ELAPSED = 0.01 * np.arange(400)
PULSE = np.where(ELAPSED > 1, np.sin(2 * np.pi * (ELAPSED - 1)), 0.0)


def written(folder, text):
    path = folder / "raw.csv"
    path.write_text(text, encoding="utf-8")
    return path


def table(names, *columns, mark=","):
    rows = [mark.join(f"{value:.9g}" for value in row) for row in zip(*columns, strict=True)]
    return "\n".join([mark.join(names), *rows] if names else rows) + "\n"


def test_the_shipped_example_is_what_its_program_makes():
    assert_shipped(raw_channels.text(), RAW.read_text(encoding="utf-8"))


def test_raw_channels_become_the_record_that_they_were_made_of(tmp_path):
    given = {"time": "t:s", "table_acceleration": "a:g", "wall": "d1:mm", "table": "d2:mm"}
    made = laboratory_record(
        read_raw(RAW),
        **{name: Channel.from_text(text) for name, text in given.items()},
        rest=0.2,
        source="here",
        synthetic=True,
    )
    expected, resting = synthetic_record(), made.elapsed < 0.2
    zeros = [getattr(expected, name)[resting].mean() for name in ("ground_acceleration", "displacement")]
    np.testing.assert_allclose(made.ground_acceleration, expected.ground_acceleration - zeros[0], atol=1e-4)
    np.testing.assert_allclose(made.displacement, expected.displacement - zeros[1], atol=2e-6)
    removed = float(made.header["acceleration_offset_removed_m_s2"])
    assert removed == pytest.approx(0.012 * STANDARD_GRAVITY + zeros[0], abs=1e-4)
    assert abs(zeros[0]) < 0.02 / np.sqrt(resting.sum()) * 3  # the pulse has not begun
    assert made.header["displacement"] == "wall less table" and made.synthetic and made.header["source"] == "here"
    write_record(tmp_path / "made.csv", made)
    assert read_record(tmp_path / "made.csv") == made


def test_a_sample_far_from_those_beside_it_is_told_with_its_time(tmp_path):
    wall = 0.05 * PULSE * np.exp(-ELAPSED)
    faulty = np.where(np.arange(400) == 250, 0.6, wall)
    given = {name: Channel.from_text(text) for name, text in (("time", "t:s"), ("wall", "d:m"))}
    for column, far in ((wall, False), (faulty, True)):  # a warning that is not awaited is an error here
        raw = read_raw(written(tmp_path, table(("t", "a", "d"), ELAPSED, PULSE, column)))
        for made in (
            lambda raw=raw: laboratory_record(raw, table_acceleration=Channel.from_text("a:m/s2"), **given),
            lambda raw=raw: laboratory_free_rocking(raw, **given),
        ):
            with pytest.warns(InputWarning, match=r"at 2\.5 s, is one sample far from") if far else nullcontext():
                made()


@pytest.mark.parametrize("mark", [",", ";", "\t", "  "])
def test_tables_are_read_with_and_without_names_by_name_or_number(tmp_path, mark):
    text = table(("time", "acc"), ELAPSED, PULSE, mark=mark)
    by_name = laboratory_record(
        read_raw(written(tmp_path, text)),
        time=Channel.from_text("time:s"),
        table_acceleration=Channel.from_text("acc:m/s2"),
    )
    bare = text.partition("\n")[2]
    by_number = laboratory_record(
        read_raw(written(tmp_path, bare)),
        time=Channel.from_text("1", "s"),
        table_acceleration=Channel.from_text("2:m/s2"),
    )
    np.testing.assert_array_equal(by_name.ground_acceleration, by_number.ground_acceleration)
    assert by_name.displacement is None


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_comma_is_a_decimal_sign_where_it_does_not_divide(tmp_path, mark):
    text = table(("t", "a"), ELAPSED, PULSE, mark=mark).replace(".", ",")
    found = read_raw(written(tmp_path, text))
    np.testing.assert_allclose(found.column("a"), PULSE, atol=1e-8)


def test_a_table_of_velocities_is_a_motion_too(tmp_path):
    t = ELAPSED - 2
    velocity = 1000 * np.exp(-((5 * t) ** 2))  # mm/s
    path = written(tmp_path, table((), ELAPSED, velocity))
    made = laboratory_record(read_raw(path), time=Channel.from_text("1:s"), table_velocity=Channel.from_text("2:mm/s"))
    np.testing.assert_allclose(made.ground_acceleration, -50 * t * np.exp(-((5 * t) ** 2)), atol=2e-3)


def test_a_filter_keeps_what_is_slow_takes_what_is_quick_and_delays_neither(tmp_path):
    quick = 0.5 * np.sin(2 * np.pi * 40 * ELAPSED)
    path = written(tmp_path, table(("t", "a"), ELAPSED, PULSE + quick))
    channels = {"time": Channel.from_text("t:s"), "table_acceleration": Channel.from_text("a:m/s2"), "baseline": "none"}
    made = laboratory_record(read_raw(path), lowpass=15.0, **channels)
    inside = slice(110, 380)
    np.testing.assert_allclose(made.ground_acceleration[inside], PULSE[inside], atol=0.02)
    coarse = laboratory_record(read_raw(path), rate=50.0, **channels)
    assert coarse.step == pytest.approx(0.02) and coarse.header["lowpass_hz"].startswith("20,")
    np.testing.assert_allclose(coarse.ground_acceleration[60:180], PULSE[120:360:2], atol=0.03)


def test_a_linear_baseline_leaves_no_velocity_at_the_end(tmp_path):
    drifting = PULSE + 0.3 + 0.05 * np.maximum(ELAPSED - 0.5, 0)
    path = written(tmp_path, table(("t", "a"), ELAPSED, drifting))
    channels = {"time": Channel.from_text("t:s"), "table_acceleration": Channel.from_text("a:m/s2")}
    made = laboratory_record(read_raw(path), baseline="linear", **channels)
    assert abs(np.trapezoid(made.ground_acceleration, made.elapsed)) < 1e-9
    np.testing.assert_allclose(made.ground_acceleration, PULSE, atol=0.01)
    constant = laboratory_record(read_raw(path), **channels)
    np.testing.assert_allclose(constant.ground_acceleration, drifting - 0.3, atol=1e-9)


def tracked(lost=(), names="frame,x"):
    """A video of 400 frames at 29.97 Hz, 0.35 mm/px, of a sine about 812 px; of lost frames the cell is empty."""
    elapsed = np.arange(400) / 29.97
    pixels = 812 + 90 * np.sin(2 * np.pi * 0.8 * elapsed)
    rows = [f"{frame}," if frame in lost else f"{frame},{x:.9g}" for frame, x in enumerate(pixels)]
    return elapsed, 0.35e-3 * pixels, "\n".join([names, *rows]) + "\n"


VIDEO = {"wall": Channel("x", "px"), "frame_rate": 29.97, "scale": 0.35e-3}


def test_a_video_has_its_time_from_the_frames_its_scale_from_the_pixels_and_lost_frames_are_filled(tmp_path):
    elapsed, displacement, text = tracked(lost=(0, 40, 41, 42, 43, 44, 100, 399))
    made = laboratory_free_rocking(read_raw(written(tmp_path, text), gaps=True), **VIDEO)
    assert made.header["samples_filled"] == "6"  # those at both ends are left out
    np.testing.assert_allclose(made.elapsed, elapsed[1:399] - elapsed[1], atol=1e-9)
    np.testing.assert_allclose(made.displacement, displacement[1:399], atol=5e-3 * 0.0315)
    once = np.isin(np.arange(1, 399), (40, 41, 42, 43, 44), invert=True)
    np.testing.assert_allclose(made.displacement[once], displacement[1:399][once], atol=1e-4 * 0.0315)
    whole = laboratory_free_rocking(read_raw(written(tmp_path, tracked()[2]), gaps=True), **VIDEO)
    assert "samples_filled" not in whole.header and whole.elapsed.size == 400


def test_rows_that_a_tracker_left_out_are_filled_too(tmp_path):
    elapsed, displacement, _ = tracked()
    seen = ~np.isin(np.arange(400), (60, 61, 300))
    path = written(tmp_path, table(("t", "x"), elapsed[seen], 1000 * displacement[seen]))
    made = laboratory_free_rocking(
        read_raw(path, gaps=True), time=Channel.from_text("t:s"), wall=Channel.from_text("x:mm")
    )
    assert made.header["samples_filled"] == "3"
    np.testing.assert_allclose(made.displacement, displacement, atol=1e-3 * 0.0315)


@pytest.mark.parametrize(
    ("changed", "lost", "message"),
    [
        ({}, range(40, 46), "6 samples are missing after 1.301 s; it must be at most 5 in a row"),
        ({"scale": None}, (), "wall is in px; a channel in px, and no other, must have a scale, as 0.35mm/px"),
        ({"wall": Channel("x", "mm")}, (), "wall is in mm; a channel in px, and no other"),
        ({"frame_rate": None}, (), "the time must be given once: as time, a column, or as frame_rate"),
        ({"frame_rate": 0.0}, (), "frame_rate is 0.0; it must be greater than 0"),
        ({"scale": -1.0}, (), "scale is -1.0; it must be greater than 0"),
    ],
)
def test_a_video_that_lost_its_marker_or_its_scale_is_refused(tmp_path, changed, lost, message):
    raw = read_raw(written(tmp_path, tracked(lost)[2]), gaps=True)
    with pytest.raises(InputError, match=message):
        laboratory_free_rocking(raw, **{**VIDEO, **changed})


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"time": "tt:s"}, "column 'tt' is not there; it must be one of t, a, d"),
        ({"table_acceleration": "a:mm"}, "table_acceleration has the unit 'mm'"),
        ({"table_acceleration": None}, "the motion must be given once"),
        ({"table": "d:mm"}, "there must be a wall"),
        ({"rest": 9.0}, "rest is 9.0; it must be at least 0 and less than"),
        ({"lowpass": 60.0}, "lowpass is 60.0; it must be at least 0.2506, a cycle in the record, and below half the"),
        ({"lowpass": 1e-9}, "lowpass is 1e-09; it must be at least 0.2506"),
        ({"rate": 0.0}, "rate is 0.0; it must be between 0.7519 and 1e"),
        ({"rate": 3e6}, "rate is 3000000.0; it must be between 0.7519 and 1e"),
        ({"baseline": "cubic"}, "baseline is 'cubic'"),
    ],
)
def test_what_cannot_be_done_is_refused_by_its_name(tmp_path, given, message):
    path = written(tmp_path, table(("t", "a", "d"), ELAPSED, PULSE, PULSE))
    options = {"time": "t:s", "table_acceleration": "a:g", **given}
    channels = {
        name: Channel.from_text(value) if isinstance(value, str) and ":" in value else value
        for name, value in options.items()
    }
    with pytest.raises(InputError, match=message):
        laboratory_record(read_raw(path), **channels)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("t,a\n0,1\n", "has no table of numbers"),
        ("t,a\n0,1\n0.1,x\n0.2,1\n", "line 3 must have 2 finite numbers"),
        ("t,a\n0,1\n0.1,1,1\n0.2,1\n", "line 3 must have 2 finite numbers"),
        ("t,a\n0,1\n0.1,inf\n0.2,1\n", "line 3 must have 2 finite numbers"),
        (f"t,a\n0,1\n0.1,{131073 * '1'}\n", "field larger than field limit .131072.; it must be a table of raw"),
    ],
)
def test_a_file_that_holds_no_table_is_refused_with_its_line(tmp_path, text, message):
    with pytest.raises(InputError, match=message):
        read_raw(written(tmp_path, text))


def test_times_with_a_gap_are_refused_with_their_row(tmp_path):
    late = np.where(np.arange(400) > 200, ELAPSED + 0.05, ELAPSED)
    path = written(tmp_path, table(("t", "a"), late, PULSE))
    with pytest.raises(InputError, match="time is 2.06 s in row 202; it must be 0.01 s after the row before"):
        laboratory_record(read_raw(path), time=Channel.from_text("t:s"), table_acceleration=Channel.from_text("a:g"))


def test_a_column_that_falls_is_questioned_as_times(tmp_path):
    path = written(tmp_path, table(("t", "a"), -ELAPSED, PULSE))
    with pytest.raises(InputError, match=r"in row 2; it must be later than the row before: is this the column"):
        laboratory_record(read_raw(path), time=Channel.from_text("t:s"), table_acceleration=Channel.from_text("a:g"))


@pytest.mark.parametrize("rows", [3, 15, 16])
def test_a_filter_has_rows_enough_or_is_refused(tmp_path, rows):
    path = written(tmp_path, table(("t", "a"), ELAPSED[:rows], PULSE[:rows]))
    run = {
        "time": Channel.from_text("t:s"),
        "table_acceleration": Channel.from_text("a:g"),
        "rest": 0.01,
        "lowpass": 49.9,
    }
    if rows == 16:
        assert laboratory_record(read_raw(path), **run).elapsed.size == 16
    else:
        with pytest.raises(InputError, match=f"the number of rows is {rows}; it must be at least 16 to filter"):
            laboratory_record(read_raw(path), **run)


def test_the_motion_of_the_table_in_the_walls_column_is_questioned(tmp_path):
    """A pulse at whose end the table is where it was; its own displacement is closed form."""
    away = ELAPSED - 2.0
    shape = np.exp(-((away / 0.3) ** 2))
    moved, motion = 0.1 * shape, 0.1 * shape * (4 * away**2 / 0.3**4 - 2 / 0.3**2)
    text = table(("t", "a", "d", "u"), ELAPSED, motion, 1000 * moved, -200 * moved)
    raw = read_raw(written(tmp_path, text))
    given = {"time": Channel("t", "s"), "table_acceleration": Channel("a", "m s-2")}
    with pytest.warns(InputWarning, match="is that of the table"):
        laboratory_record(raw, **given, wall=Channel("d", "mm"))
    laboratory_record(raw, **given, wall=Channel("u", "mm"))


def test_channels_of_wall_and_table_that_do_not_go_with_the_motion_are_questioned(tmp_path):
    """The wall goes with the table and rocks a tenth of its motion besides, at another frequency."""
    moved = 0.1 * np.sin(2 * np.pi * ELAPSED) * np.hanning(ELAPSED.size)
    motion = CubicSpline(ELAPSED, moved)(ELAPSED, 2)
    rocked = moved + 0.01 * np.sin(4 * np.pi * ELAPSED) * np.hanning(ELAPSED.size)
    raw = read_raw(written(tmp_path, table(("t", "a", "w", "d"), ELAPSED, motion, 100 * rocked, 100 * moved)))
    given = {"time": Channel("t", "s"), "table_acceleration": Channel("a", "m s-2"), "baseline": "none"}
    with pytest.warns(InputWarning, match="were they swapped"):
        laboratory_record(raw, **given, wall=Channel("d", "cm"), table=Channel("w", "cm"))
    laboratory_record(raw, **given, wall=Channel("w", "cm"), table=Channel("d", "cm"))
    in_feet = given | {"table_acceleration": Channel("a", "ft s-2")}
    with pytest.warns(InputWarning, match="3.28 times what its acceleration gives; are both units right"):
        laboratory_record(raw, **in_feet, wall=Channel("w", "cm"), table=Channel("d", "cm"))
    turned = read_raw(written(tmp_path, table(("t", "a", "w", "d"), ELAPSED, -motion, 100 * rocked, 100 * moved)))
    with pytest.warns(InputWarning, match="-1 times what its acceleration gives; is the sign of one wrong"):
        laboratory_record(turned, **given, wall=Channel("w", "cm"), table=Channel("d", "cm"))


def test_a_line_of_units_a_transposed_table_and_a_record_of_peer_are_known(tmp_path):
    raw = read_raw(written(tmp_path, "t,a,d\ns,m/s2,mm\n0,0,1\n0.1,0,2\n0.2,0,3\n"))
    assert list(raw.names) == ["t", "a", "d"]
    with pytest.raises(
        InputError, match="has 2 rows and 40 columns; a row must hold one time: is the table transposed"
    ):
        read_raw(written(tmp_path, "\n".join(",".join(["1.0"] * 40) for _ in range(2))))
    peer = tmp_path / "a.AT2"
    peer.write_text("1 2 3\n4 5 6\n", encoding="utf-8")
    with pytest.raises(InputError, match="is a record of PEER, which respond, assess and batch read as it is"):
        read_raw(peer)


def test_a_motion_and_a_displacement_in_each_others_columns_are_asked_about(tmp_path):
    moved = 30 * np.sin(2 * np.pi * ELAPSED)  # mm; as g it is no earthquake's
    raw = read_raw(written(tmp_path, table(("t", "a", "d"), ELAPSED, 0.4 * np.cos(9 * ELAPSED), moved)))
    given = {"time": Channel("t", "s"), "baseline": "none"}
    with pytest.warns(InputWarning, match="or were its column and that of the wall exchanged"):
        laboratory_record(raw, **given, table_acceleration=Channel("d", "g"), wall=Channel("a", "mm"))
    laboratory_record(raw, **given, table_acceleration=Channel("a", "g"), wall=Channel("d", "mm"))


def test_a_unit_a_column_or_a_filter_that_does_not_go_with_the_motion_is_questioned(tmp_path):
    away = ELAPSED - 2.0
    moved = 0.1 * np.exp(-((away / 0.3) ** 2))
    motion = moved * (4 * away**2 / 0.3**4 - 2 / 0.3**2)
    rocked = 0.01 * np.sin(20 * away) * np.exp(-((away / 0.5) ** 2))
    raw = read_raw(written(tmp_path, table(("t", "a", "w", "d"), ELAPSED, motion, 1000 * rocked, 1000 * moved)))
    given = {"time": Channel("t", "s"), "table_acceleration": Channel("a", "m s-2"), "wall": Channel("w", "mm")}
    laboratory_record(raw, **given, table=Channel("d", "mm"))
    with pytest.warns(InputWarning, match=r"over 1.2 g, with its numbers taken as g; .* m s-2 \(2.22 m s-2\)"):
        laboratory_record(raw, **given | {"table_acceleration": Channel("a", "g")})
    with pytest.warns(InputWarning, match="under 0.005 g, with its numbers taken as cm s-2"):
        laboratory_record(raw, **given | {"table_acceleration": Channel("a", "gal")})
    with pytest.warns(InputWarning, match="is unlike what its acceleration gives"):
        velocity = {"table_velocity": Channel("a", "m/s"), "table_acceleration": None}
        laboratory_record(raw, **given | velocity, table=Channel("d", "mm"))
    with pytest.warns(InputWarning, match="the filter of 0.5 Hz takes PGA from 2.22 to"):
        laboratory_record(raw, **given, lowpass=0.5, baseline="none")
    with pytest.raises(InputError, match="columns 'w' and 'w' have the same numbers"):
        laboratory_record(raw, **given, table=Channel("w", "mm"))

"""Reading and writing records, and what a bad one is told."""

import copy
import pickle
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rockdamp.errors import InputError
from rockdamp.motions.records import Record, followed_by_rest, has_displacement, read_record, write_record
from rockdamp.vocabulary import STANDARD_GRAVITY

HEADER = "# specimen: A\n# source: B, 2017: table 3\n# licence: CC0-1.0\n# units: s, m s-2, m\n# synthetic: yes\n"
COLUMNS = "elapsed_s,ground_acceleration_m_s2,displacement_m\n"
ROWS = "0.00,0.1,0.001\n0.01,0.2,0.002\n0.02,-0.3,0.003\n0.03,0.0,0.004\n"
FIRST_ROW = 7  # line of the first row in HEADER + COLUMNS + ROWS

AT2 = """PEER NGA STRONG MOTION DATABASE RECORD
Somewhere, 1/2/1990, Station, 90
ACCELERATION TIME SERIES IN UNITS OF G
NPTS=   7, DT=   .0050 SEC
  -.1000000E-01  .2000000E-01  .3000000E-01  .0000000E+00  .5000000E-02
   .6000000E-02 -.7000000E-02
"""


@pytest.fixture
def write(tmp_path):
    def write(text, name="record.csv"):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return path

    return write


def times(count=40, step=0.01):
    return np.arange(count) * step


# --- good files


def test_a_csv_gives_its_columns_and_its_header(write):
    record = read_record(write(HEADER + COLUMNS + ROWS))
    np.testing.assert_array_equal(record.elapsed, [0.0, 0.01, 0.02, 0.03])
    np.testing.assert_array_equal(record.ground_acceleration, [0.1, 0.2, -0.3, 0.0])
    np.testing.assert_array_equal(record.displacement, [0.001, 0.002, 0.003, 0.004])
    assert record.header["source"] == "B, 2017: table 3"
    assert record.synthetic
    assert record.step == pytest.approx(0.01, rel=1e-12)


@pytest.mark.parametrize("mark", [";", "\t"])
def test_a_spreadsheet_s_marks_and_decimal_commas_make_the_same_record(write, mark):
    table = (COLUMNS + ROWS).replace(",", mark).replace(".", ",")
    assert read_record(write("\ufeff" + HEADER + table)) == read_record(write(HEADER + COLUMNS + ROWS))


@pytest.mark.parametrize(
    ("text", "there"), [(COLUMNS + ROWS, True), ("elapsed_s,ground_acceleration_g\n0,1\n1,2\n", False)]
)
def test_whether_a_displacement_was_measured_is_known_from_the_names_of_the_columns(write, text, there):
    path = write(HEADER + text)
    assert has_displacement(path) == there == (read_record(write(text)).displacement is not None)


def test_displacement_may_be_missing_and_a_record_without_a_header_is_taken_as_measured(write):
    record = read_record(write("elapsed_s,ground_acceleration_m_s2\n0,1\n1,2\n"))
    assert record.displacement is None
    assert not record.synthetic


finite = st.floats(-1e3, 1e3)


@given(st.lists(st.tuples(finite, finite), min_size=2, max_size=20))
def test_writing_and_reading_a_record_gives_the_same_numbers(tmp_path_factory, samples):
    path = tmp_path_factory.mktemp("records") / "record.csv"
    acceleration, displacement = np.array(samples).T
    record = Record(times(len(samples), 1 / 256), acceleration, displacement, {"specimen": "A", "synthetic": "no"})
    write_record(path, record)
    back = read_record(path)
    for name in ("elapsed", "ground_acceleration", "displacement"):
        np.testing.assert_array_equal(getattr(back, name), getattr(record, name))
    assert back.header == record.header
    assert [entry.name for entry in path.parent.iterdir()] == ["record.csv"]


@pytest.mark.parametrize(
    "fourth", ["NPTS=   7, DT=   .0050 SEC", "   7    0.0050    NPTS, DT", "NPTS= 7, DT= 5.0E-03 SEC,"]
)
def test_an_at2_file_becomes_metres_and_seconds(write, fourth):
    record = read_record(write(AT2.replace("NPTS=   7, DT=   .0050 SEC", fourth), "RSN1.AT2"))
    np.testing.assert_allclose(record.elapsed, 0.005 * np.arange(7), rtol=1e-15)
    expected = np.array([-0.01, 0.02, 0.03, 0, 0.005, 0.006, -0.007]) * STANDARD_GRAVITY
    np.testing.assert_allclose(record.ground_acceleration, expected, rtol=1e-15)
    assert record.displacement is None
    assert "Station, 90" in record.header["source"]
    assert not record.synthetic


# --- bad files


BAD = {
    "a gap": (ROWS.replace("0.2", ""), f"'' on line {FIRST_ROW + 1}; it must be a number"),
    "NaN": (ROWS.replace("-0.3", "NaN"), f"ground_acceleration_m_s2 is nan on line {FIRST_ROW + 2}; .*finite"),
    "text": (ROWS.replace("0.2", "zero"), f"ground_acceleration_m_s2 is 'zero' on line {FIRST_ROW + 1}; .*a number"),
    "time going back": (ROWS.replace("0.02,", "0.005,"), f"elapsed_s is 0.005 on line {FIRST_ROW + 2}; .*than 0.01"),
    "a missing sample": (
        "".join(f"{t / 100:.2f},0,0\n" for t in range(20) if t != 11),
        f"elapsed_s is 0.12 on line {FIRST_ROW + 11}; it must be 0.11: .*uniform to 0.0001 .*; are samples missing",
    ),
    "uneven times": (
        "".join(f"{t / 100 + (t == 11) / 500:.3f},0,0\n" for t in range(20)),
        f"elapsed_s is 0.12 on line {FIRST_ROW + 12}; .*be written with as many digits$",
    ),
    "a short row": (ROWS.replace(",0.002", ""), f"line {FIRST_ROW + 1} has 2 values; it must have 3"),
    "decimal commas": (ROWS.replace("0.2", "0,2"), f"line {FIRST_ROW + 1} has 4 values; it must have 3"),
    "no rows": ("", f"has no rows; at least 2 must follow the columns on line {FIRST_ROW - 1}"),
    "one row": (ROWS[:15], "has 1 samples; it must have at least 2"),
}


@pytest.mark.parametrize("name", BAD)
def test_a_bad_row_is_named_with_its_value_line_and_file(write, name):
    rows, message = BAD[name]
    path = write(HEADER + COLUMNS + rows)
    with pytest.raises(InputError, match=f"^{re.escape(str(path))}: .*{message}"):
        read_record(path)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ("elapsed_s,displacement_m", "column 'ground_acceleration_m_s2' is missing on line 6; the columns must be"),
        ("ground_acceleration_m_s2", "column 'elapsed_s' is missing on line 6"),
        ("time,ground_acceleration_m_s2", "column 'time' on line 6 is unknown; the columns must be elapsed_s"),
    ],
)
def test_wrong_or_missing_columns_are_named(write, columns, message):
    with pytest.raises(InputError, match=message):
        read_record(write(HEADER + columns + "\n" + ROWS))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (HEADER.encode(), "has a header only; columns elapsed_s, ground_acceleration_m_s2 must follow"),
        ((HEADER.replace("yes", "maybe") + COLUMNS + ROWS).encode(), "synthetic is 'maybe'; it must be yes or no"),
        (AT2.encode(), "the name of a PEER AT2 file must end in .AT2"),
    ],
)
def test_a_file_that_is_no_record_says_why(write, content, message):
    path = write(content)
    with pytest.raises(InputError, match=f"^{re.escape(str(path))}: .*{message}"):
        read_record(path)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("   .6000000E-02 -.7000000E-02\n", "", "has 5 accelerations; it must have 7, as NPTS on line 4 says"),
        ("-.7000000E-02", "-.7000000E-02 .1", "has 8 accelerations; it must have 7"),
        ("-.7000000E-02", "*****", r"acceleration is '\*\*\*\*\*' on line 6; it must be a number"),
        ("NPTS=   7, DT=   .0050 SEC", "7 samples", "line 4 is '7 samples'; it must give NPTS and DT"),
    ],
)
def test_a_bad_at2_file_says_what_and_where(write, old, new, message):
    assert old in AT2
    with pytest.raises(InputError, match=message):
        read_record(write(AT2.replace(old, new), "bad.at2"))


# --- time


def test_a_clock_that_drifts_is_refused_though_no_interval_is_far_off():
    step = 0.01 * (1 + np.linspace(0, 5e-5, 2000))
    assert np.ptp(step) < 1e-4 * 0.01
    with pytest.raises(InputError, match="uniform"):
        Record(np.concatenate([[0.0], np.cumsum(step)]), np.zeros(2001))


def test_a_record_made_in_python_is_checked_too():
    with pytest.raises(InputError, match="displacement_m has shape"):
        Record(times(), np.zeros(40), np.zeros(39))
    with pytest.raises(InputError, match=r"elapsed_s has shape \(2, 40\); it must be \(samples,\)"):
        Record(np.vstack([times(), times()]), np.zeros(40))
    with pytest.raises(InputError, match="ground_acceleration_m_s2 is nan at sample 3"):
        Record(times(), np.where(np.arange(40) == 3, np.nan, 0.0))


# --- writing


@pytest.mark.parametrize(("tail", "zeros"), [(0.0, 0), (1e-9, 1), (0.5, 50), (0.501, 51)])
def test_the_rest_after_a_motion_lasts_at_least_as_long_as_asked_for(tail, zeros):
    motion = np.array([1.0, -2.0, 3.0])
    assert followed_by_rest(motion, 0.01, tail).tolist() == [1.0, -2.0, 3.0] + [0.0] * zeros


def test_a_record_stays_as_it_was_checked_as_do_its_copies():
    record = Record(times(), np.sin(times()), header={"Synthetic": "yes"}, digest="d")
    for same in (record, pickle.loads(pickle.dumps(record)), copy.copy(record), copy.deepcopy(record)):
        assert same == record and same.synthetic and same.digest == "d"
        with pytest.raises(TypeError, match="does not support item assignment"):
            same.header["synthetic"] = "no"
        with pytest.raises(ValueError, match="read-only"):
            same.ground_acceleration[0] = 1.0


def test_a_time_off_by_more_than_the_tolerance_is_refused_at_its_sample():
    elapsed = times()
    elapsed[17] += 3e-4 * 0.01
    with pytest.raises(InputError, match="at sample 1[78]; .*uniform"):
        Record(elapsed, np.zeros(40))

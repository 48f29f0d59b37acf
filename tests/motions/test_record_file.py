"""Files of records: the formats that are read, and the refusals of all others."""

import re

import numpy as np
import pytest

from rockdamp.constants import STANDARD_GRAVITY as G
from rockdamp.errors import InputError
from rockdamp.motions.record import Record
from rockdamp.motions.record_file import read_record, write_record

VALUES = [0, 0.1, -0.2, 0.3, 0]
CSV = "elapsed_s,ground_acceleration_m_s2\n0,0\n0.005,0.1\n0.01,-0.2\n0.015,0.3\n0.02,0\n"
UNIT = "ACCELERATION TIME SERIES IN UNITS OF G"
COUNT = "NPTS=   5, DT=   .0050 SEC,"
MANY_TITLES = (
    "Data\n5 points\n8F10.5, i.e. 8 across in\na row\nThe units are (g)\n*** Begin data ***\n"
)
ROTATED = "Orig\n H1: X 10/15/79, 000\n H2\n angle -37.0\n azimuth = 233.0\n Acceleration in g\n"
STEP_AND_UNIT = {"step": 0.005, "unit": "g"}
N = np.arange(2000)


def at2(unit=UNIT, count=COUNT):
    return f"PEER\nSomewhere, 090\n{unit}\n{count}\n .0 .1D0 -2E-1 .3\n.0\n"


def csv(times, number_format):
    rows = []
    for index, elapsed in enumerate(times.tolist()):
        rows.append(f"{number_format.format(elapsed)},{index % 7 - 3}\n")
    return f"elapsed_s,ground_acceleration_m_s2\n{''.join(rows)}"


@pytest.fixture
def read(tmp_path):
    def write_and_read(text, **options):
        path = tmp_path / "record.txt"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_record(path, **options)

    return write_and_read


@pytest.fixture
def refuses(read, tmp_path):
    """Assert that a file is refused with its path and one line, which has a pattern."""

    def read_and_match(pattern, text, **options):
        with pytest.raises(InputError) as error:
            read(text, **options)
        path, _, line = str(error.value).partition(": ")
        assert path == str(tmp_path / "record.txt")
        assert "\n" not in line
        assert len(line) <= 160, line
        assert re.search(pattern, line), line

    return read_and_match


def test_written_record_is_read_back_to_the_same_bits(tmp_path):
    rng = np.random.default_rng(1)
    header = {"specimen": "a wall: the second", "synthetic": "yes"}
    written = Record(np.arange(50) / 30, rng.normal(size=50), rng.normal(size=50), header)
    write_record(tmp_path / "record.csv", written)
    record = read_record(tmp_path / "record.csv")
    for name in ("elapsed", "ground_acceleration", "displacement"):
        np.testing.assert_array_equal(getattr(record, name), getattr(written, name))
    assert record.header == header and record.synthetic and len(record.digest) == 64
    assert [path.name for path in tmp_path.iterdir()] == ["record.csv"]


@pytest.mark.parametrize(
    "header",
    [{"source": "one\ntwo"}, {"source": "one\r"}, {"a\nb": "c"}, {"source": "one\u2028two"}],
)
def test_line_break_in_a_header_is_not_written(header, tmp_path):
    record = Record([0.0, 0.01, 0.02], [0, 1, 0], header=header)
    with pytest.raises(InputError, match="line breaks"):
        write_record(tmp_path / "record.csv", record)
    assert list(tmp_path.iterdir()) == []


# --- formats that are read ---------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        (CSV, 1),
        (CSV.replace("m_s2", "g"), G),
        (CSV.replace("m_s2", "cm_s2"), 0.01),
        ("\ufeff# units: s, m s-2\n#\n" + CSV.replace("\n", "\r\n"), 1),
        (CSV.replace("\n", "\r"), 1),
        (CSV.replace(",", ";"), 1),
        (CSV.replace(",", " \t "), 1),
        (CSV.replace("0.005", '"0.005"').replace("0.1\n", "0.1 # here\n") + "\n\n# the end\n", 1),
        (
            "ground_acceleration_m_s2,note,elapsed_s\n"
            "0,9,0\n.1,9,5e-3\n-.2,9,1e-2\n.3,9,1.5e-2\n0,9,2e-2\n",
            1,
        ),
        (
            ",elapsed_s,ground_acceleration_m_s2\n"
            "0,0,0\n1,.005,.1\n2,.01,-.2\n3,.015,.3\n4,.02,0\n",
            1,
        ),
    ],
)
def test_csv_of_any_program_is_read(text, factor, read):
    record = read(text)
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * factor, rtol=1e-15)
    assert (record.step, record.displacement, record.synthetic) == (0.005, None, False)


@pytest.mark.parametrize(
    ("text", "factor"),
    [
        (at2("ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 Hz LP=30.0 Hz"), G),
        (at2("ACCELERATION (G)"), G),
        (at2("ACCELERATION IN CM/S/S"), 0.01),
        (at2("UNITS: CM/SEC**2"), 0.01),
        (at2("ACCELERATION (M/S**2)"), 1),
        (at2("Units are cm / sec / sec"), 0.01),
        (at2("IN GAL"), 0.01),
        (at2(count="NPTS 5 DT 5.0D-3 SEC"), G),
        (at2(count="DT=0.005 NPTS=5"), G),
        (at2(count="5 .005 NPTS, DT"), G),
        (at2(count=" .005  5  DT, NPTS"), G),
        (f"PEER {UNIT}\n{COUNT}\n.0\n.1\n-.2\n.3\n.0\n", G),
        (MANY_TITLES + "NPTS= 5, DT= .005\n0 .1 -.2 .3 0", G),
        (ROTATED + "5 .005 NPTS, DT \n0 .1 -.2 .3 0", G),
    ],
)
def test_at2_file_is_in_the_unit_that_it_states(text, factor, read):
    record = read(text)
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * factor, rtol=1e-15)
    assert record.step == 0.005
    assert record.header["source"].startswith(text.partition("\n")[0])


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("0\n.1\n-.2\n.3\n0\n", STEP_AND_UNIT),
        ("0,\n.1,\n-.2,\n.3,\n0,\n", STEP_AND_UNIT),
        ("300 points, no more\nThe units are (g)\n*** Begin ***\n0\n.1\n-.2\n.3\n0", STEP_AND_UNIT),
        ("10 March 2011\n 0.00E+00\r\n1.00D-01\r\n-2.00e-01\r\n 3.00E-01\r\n 0\r\n", STEP_AND_UNIT),
        ("5\n0 .1 -.2 .3 0\n", STEP_AND_UNIT),
        ("5\n0 .1 -.2\n.3 0\n", STEP_AND_UNIT),
        ("Title\n5 .005\n0 .1 -.2 .3 0\n", STEP_AND_UNIT),
        ("Title\n5 .005\n0\n.1\n-.2\n.3\n0\n# the end\n", {"unit": "g"}),
        ("t a\n0 0\n.005 .1\n.010 -.2\n.015 .3\n.020 0\n", {"unit": "g"}),
        ("t;a\n0;0\n.005;.1\n.010;-.2\n.015;.3\n.020;0\n", {"unit": "g"}),
        ("t,a\n0,0\n5e-3,.1\n1e-2,-.2\n1.5e-2,.3\n2e-2,0\n", {"unit": "g"}),
        ("N E\n0 9\n.1 9\n-.2 9\n.3 9\n0 9\n", STEP_AND_UNIT | {"column": 1}),
        ("N\tE\tZ\n9\t0\t9\n9\t.1\t9\n9\t-.2\t9\n9\t.3\t9\n9\t0\t9", STEP_AND_UNIT | {"column": 2}),
        (at2("The units are those of the logger"), {"unit": "g"}),
    ],
)
def test_plain_numbers_are_read(text, options, read):
    record = read(text, **options)
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * G, rtol=1e-15)
    assert record.step == pytest.approx(0.005, rel=1e-12)


def test_counts_are_read_as_whole_numbers(read):
    record = read("12\n-3\n4\n", step=0.01, unit="mg")
    np.testing.assert_allclose(record.ground_acceleration, np.array([12, -3, 4]) * G / 1000)


@pytest.mark.parametrize(
    ("step", "times", "number_format"),
    [
        (1 / 128, N / 128, "{:.3f}"),
        (1 / 128, np.floor(N / 128 * 1000) / 1000, "{:.3f}"),
        (1 / 240, N / 240, "{:.3f}"),
        (1 / 60, N / 60, "{:.2f}"),
        (1 / 256, N / 256, "{:.5f}"),
        (0.005, 1.7e9 + 0.005 * N, "{:.3f}"),
        (0.005, 1.7e9 + 0.005 * N, "{:.6f}"),
        (0.05, 0.05 * N, "{:g}"),
        (0.01, 0.01 * N + 9e-5 * (N % 2), "{:.6f}"),
        (0.005, 0.005 * N, "{:.3e}"),
        (0.01, np.cumsum(np.full(2000, 0.01)), "{!r}"),
        (0.005, (0.005 * N).astype(np.float32).astype(float), "{:.17g}"),
    ],
)
def test_rounded_times_are_uniform(step, times, number_format, read):
    """Times that a logger rounded, cut off or summed up."""
    record = read(csv(times, number_format))
    assert record.elapsed.size == 2000
    assert record.step == pytest.approx(step, rel=1e-3)


@pytest.mark.parametrize("number_format", ["{:.3f}", "{!r}"])
def test_200_000_samples_are_read(number_format, read):
    text = csv(np.arange(200_000) / 128, number_format)
    assert read(text).elapsed.size == 200_000


# --- refusals ----------------------------------------------------------------------------------


MISSING = "1 sample is missing after"


@pytest.mark.parametrize(
    ("times", "number_format", "pattern"),
    [
        (np.delete(0.01 * N, 1000), "{:.2f}", f"from 9.99 to 10.01.*{MISSING} 9.99"),
        (
            np.delete(N / 240, [900, 901, 902]),
            "{:.3f}",
            "to 3.763.*3 samples are missing after 3.746",
        ),
        (np.delete(N / 60, 1000), "{:.2f}", f"{MISSING} 16.65"),
        (np.delete(N, 700), "{:d}", f"from 699.0 to 701.0.*{MISSING} 699.0"),
        (np.insert(0.01 * N, 5, 0.04), "{:.2f}", "from 0.04 to 0.04"),
        (np.r_[0, 1, 3, 2, 4:100] * 0.01, "{:.2f}", "from 0.01 to 0.03"),
        (np.r_[0.01 * N[:100], 1.0035 + 0.01 * N[:100]], "{:.4f}", "elapsed"),
        (0.01 * N[::-1], "{:.2f}", "from 19.99 to 19.98"),
        (0.01 * N * (1 + N * 1e-6), "{:.6f}", "elapsed"),
        (1e-5 * N * (1 + N * 1e-6), "{:.4e}", "elapsed"),
        (0.01 * N + 0.002 * (N == 50), "{:.3f}", "elapsed"),
    ],
)
def test_gap_double_or_swap_is_named_with_its_time(times, number_format, pattern, refuses):
    refuses(pattern, csv(times, number_format))


CHANNELS = ",".join(f"channel_{number}" for number in range(20))


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("", "numbers"),
        ("elapsed_s,ground_acceleration_m_s2\n", "numbers"),
        ("elapsed_s,ground_acceleration_m_s2\n0,0\n", "1 samples"),
        ("elapsed_s,displacement_m\n0,1\n1,2\n", "elapsed_s, displacement_m"),
        ("elapsed_s,ground_acceleration_m_s2,ground_acceleration_g\n0,1,1\n1,2,2\n", "columns"),
        (
            "elapsed_s,ground_acceleration_g,elapsed_s\n0,1,0\n.01,2,9\n",
            "the column 'elapsed_s' twice",
        ),
        (f"elapsed_s,{CHANNELS}\n0{',1' * 20}\n", "elapsed_s, channel_0"),
        (CSV + "0.04\n", "line 7 is '0.04'"),
        (CSV + "0.04,1,2\n", "line 7"),
        (CSV + "0.04,nan\n", "line 7"),
        (CSV + "Mean,0.1\n", "line 7"),
        (CSV.replace("0.005", "5").replace("0.01", "10"), "elapsed"),
        ("# synthetic: perhaps\n" + CSV, "synthetic is 'perhaps'"),
        (CSV.encode("utf-16"), "(?=.*0xff).*line 1"),
        ("# Universit\xe9\n".encode("latin-1") + CSV.encode(), "(?=.*0xe9).*line 1"),
        (at2("The units are those of the logger"), "unit"),
        (at2("ACCELERATION IN CM/S/S (G)"), "2 units"),
        (at2(count="NPTS= 6, DT= .005"), "(?=.*5).*6"),
        (at2(count="NPTS= 5, DT= 10 MSEC"), "step is 10 s"),
        (at2(count="NPTS= 5, DT= -.005 SEC"), "step is -0.005 s"),
        (at2().replace(".1D0 -2E-1", "0.1E-01-0.2E-01"), "line 5 is '.0 0.1E-01-0.2E-01"),
        (at2().replace(".3", "6.3"), "(?=.*peak of 6.3 g).*at most 5 g"),
    ],
)
def test_file_that_contradicts_its_head_is_refused(text, pattern, refuses):
    refuses(pattern, text)


@pytest.mark.parametrize(
    ("text", "options", "pattern"),
    [
        (CSV, {"step": 0.01}, "step is 0.01.*0.005"),
        (CSV, {"unit": "g"}, "unit"),
        (CSV, {"unit": "cm"}, "unit is 'cm'"),
        (CSV, {"column": 2}, "column is 2"),
        (at2("VELOCITY TIME SERIES IN UNITS OF CM/S"), {"unit": "g"}, "VELOCITY"),
        (at2("Displacement (CM)"), {"unit": "g"}, "Displacement"),
        (at2(), {"unit": "cm/s2"}, "unit"),
        (at2(), {"step": 0.01}, "step is 0.01.*0.005"),
        (at2(), {"column": 1}, "column is 1"),
    ],
)
def test_file_that_contradicts_an_option_is_refused(text, options, pattern, refuses):
    refuses(pattern, text, **options)


ROWS = " 0.1 0.2 0.3\n-0.1 0.0 0.4\n"
THREE_COMPONENTS = f"UNIT: cm/s2\n N-S E-W U-D\n{ROWS}"
TIMES = "".join(f"{k} {k % 3}\n" for k in [*range(20), 21, 20, *range(22, 40)])


@pytest.mark.parametrize(
    ("text", "options", "pattern"),
    [
        ("0\n.1\n-.2\n", {}, "unit"),
        ("0\n.1\n-.2\n", {"step": 0.01}, "unit"),
        ("0\n.1\n-.2\n", {"unit": "g"}, "one column.*step"),
        ("0\n.1\n", {"step": 0, "unit": "g"}, "step is 0"),
        ("i t a\n0 0 0\n1 .005 .1\n2 .01 .2\n", {"unit": "g"}, "3 columns"),
        ("i a\n0 0\n1 .1\n2 .2\n", {"unit": "g"}, "step is 1 s"),
        ("0 0\n.005 .1\n.02 .2\n.025 0\n", {"unit": "g"}, "0.005 to 0.02.*2 samples are"),
        (TIMES, {"unit": "g"}, "from 19.0 to 21.0"),
        (THREE_COMPONENTS, {"unit": "g"}, "3 columns"),
        ("5 .005\n0 .1 -.2 .3 0\n", {"step": 0.01, "unit": "g"}, "step is 0.01.*0.005"),
    ],
)
def test_plain_numbers_need_a_unit_and_even_times(text, options, pattern, refuses):
    refuses(pattern, text, **options)


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("0 .1 -.2 .3 0\n", "5 columns"),
        ("0 0\n.005 .1\n.010 .2\n", "2 columns.*step must be left out"),
        (THREE_COMPONENTS, "3 columns"),
        (THREE_COMPONENTS.replace(" ", "\t"), "columns"),
        (f"2\n{ROWS}", "line 1 is '2'; it has 1 number; most lines have 3"),
        ("0\n.1\n9.81\n", "peak of 9.81 g"),
    ],
)
def test_plain_numbers_of_other_columns_are_refused(text, pattern, refuses):
    refuses(pattern, text, **STEP_AND_UNIT)


@pytest.mark.parametrize(("column", "pattern"), [(4, "column is 4.*1 to 3"), (0, "column is 0")])
def test_column_outside_the_file_is_refused(column, pattern, refuses):
    refuses(pattern, THREE_COMPONENTS, column=column, **STEP_AND_UNIT)


@pytest.mark.parametrize(
    ("head", "pattern"),
    [
        ("5 .005 656\n", "line 2 is '5 .005 656'; it has 3 numbers; most lines have 1"),
        ("2011 03 11\n", "line 2 is '2011 03 11'"),
        ("2011/03/11 14:46:18.1\n", "line 2 is '2011/03/11 14:46:18.1'"),
        ("20110311\n", "line 2 is '20110311'"),
        ("6\n", "line 2 is '6'"),
        ("6 .005\n", "line 2 is '6 .005'"),
        ("100\n200\n", "line 2 is '100'"),
        ("0\n200\n", "line 3 is '200'"),
        ("nan\n", "line 2 is 'nan'"),
        ("-0.1-0.2\n", "line 2 is '-0.1-0.2'"),
    ],
)
def test_head_of_numbers_is_no_acceleration(head, pattern, refuses):
    refuses(pattern, f"Station\n{head}.0\n.1\n-.2\n.3\n.0\n", step=0.005, unit="cm/s2")


@pytest.mark.parametrize("value", ["--", "N/A", "NaN", "inf", "1,5"])
def test_first_row_with_a_missing_value_is_no_title(value, refuses):
    refuses("line 2 is '0.00", f"t a\n0.00 {value}\n0.01 .1\n0.02 .2\n", unit="g")


TSPAIR = (
    "TIMESERIES XX_TEST__BHZ_R, 3 samples, 20 sps, 2003-05-29T02:13:22.043400, TSPAIR, INTEGER\n"
    "2003-05-29T02:13:22.043400  2787\n2003-05-29T02:13:22.093400  2776\n"
)
GEOCSV = (
    "# dataset: GeoCSV 2.0\n# delimiter: ,\nTime, Sample\n"
    "2003-05-29T02:13:22.043400Z,2787\n2003-05-29T02:13:22.093400Z,2776\n"
)


@pytest.mark.parametrize(
    ("text", "pattern"),
    [
        ("t,a\n00:00:00.00,0.1\n00:00:00.01,0.2\n", "line 2 is '00:00:00.00,0.1'"),
        (TSPAIR, "line 2 is '2003-05-29T.*'2003-05-29T02:13:22.' is not a finite number"),
        (GEOCSV, "line 4 is '2003-05-29T"),
        ("one\ntwo\n", "line 1 is 'one'"),
    ],
)
def test_first_line_that_does_not_read_is_named(text, pattern, refuses):
    refuses(pattern, text, unit="g")


@pytest.mark.parametrize(
    "text",
    [
        "0,000\n0,125\n-0,250\n",
        "0,00;0,000\n0,01;0,125\n0,02;0,250\n",
        "0,00\t0,000\n0,01\t0,125\n0,02\t0,250\n",
        "0,00  0,000\n0,01 -0,125\n0,02  0,250\n",
        "t a\n0,00  0,0E+00\n0,01 -1,2E-01\n0,02  2,5E-01\n",
        CSV.replace(",", ";").replace(".", ","),
        CSV.replace(".", ","),
    ],
)
def test_decimal_comma_is_named(text, refuses):
    refuses("the decimal sign must be a point", text, unit="m/s2")


def test_unknown_column_of_times_is_named(refuses):
    numbers = "time,ground_acceleration_cm_s2\n0,0\n0.01,10\n"
    refuses("columns are time, .* column of times must be elapsed_s", numbers)


FORMATS = {
    "GeoNet": "Corrected accelerogram\nSite X\nAcceleration: mm/s/s\n 0 0 0\n"
    f"{ROWS}Velocity: mm/s\n{ROWS}",
    "AFAD": f"PLACE : X\nSAMPLE INTERVAL (sec.) : 0.01\nNUMBER OF DATA : 6\n\n N-S E-W U-D\n{ROWS}",
    "SMC": "2 CORRECTED ACCELEROGRAM\n*\nStation X\n 1 2 3\n 1.7e+38 2.0e+02 3.0\n"
    f"| a comment\n{ROWS}",
    "COSMOS": f"Uncorrected acceleration\n 100 Integers follow\n 1 2\n 100 Reals follow\n{ROWS}",
    "K-NET": "Origin Time 2011\nSampling Freq(Hz) 100Hz\nScale Factor 7845(gal)/8223790\n"
    "Memo.\n 1234567 7654321\n",
    "ESM": "SAMPLING_INTERVAL_S: 0.005\nNDATA: 2\nUNITS: cm/s^2\n0.012345678\n-0.012345678\n",
}


@pytest.mark.parametrize("name", FORMATS)
def test_other_format_is_refused_with_the_columns_to_write(name, refuses):
    refuses("elapsed_s, ground_acceleration_m_s2", FORMATS[name])

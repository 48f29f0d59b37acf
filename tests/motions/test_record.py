"""Files of records: which are read, to which numbers, and which are refused where."""

import time

import numpy as np
import pytest

from rockdamp.constants import STANDARD_GRAVITY as G
from rockdamp.errors import InputError
from rockdamp.motions.record import Record, append_rest, read_record, write_record

VALUES = [0, 0.1, -0.2, 0.3, 0]
CSV = "elapsed_s,ground_acceleration_m_s2\n0,0\n0.005,0.1\n0.01,-0.2\n0.015,0.3\n0.02,0\n"
UNIT, COUNT = "ACCELERATION TIME SERIES IN UNITS OF G", "NPTS=   5, DT=   .0050 SEC,"
SHARED = "Data\n5 points\n8F10.5, i.e. 8 across in\na row\nThe units are (g)\n*** Begin data ***\n"
ROTATED = "Orig\n H1: X 10/15/79, 000\n H2\n angle -37.0\n azimuth = 233.0\n Acceleration in g\n"
STEP_AND_UNIT = {"step": 0.005, "unit": "g"}
N = np.arange(2000)


def at2(unit=UNIT, count=COUNT):
    return f"PEER\nSomewhere, 090\n{unit}\n{count}\n .0 .1D0 -2E-1 .3\n.0\n"


def csv(times, printed):
    rows = "".join(
        f"{printed.format(each)},{index % 7 - 3}\n" for index, each in enumerate(times.tolist())
    )
    return f"elapsed_s,ground_acceleration_m_s2\n{rows}"


@pytest.fixture
def read(tmp_path):
    def reader(text, **options):
        path = tmp_path / "record.txt"
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_record(path, **options)

    return reader


@pytest.fixture
def message(read, tmp_path):
    """The one line that refuses a file, without its path."""

    def refusal(text, **options):
        with pytest.raises(InputError) as refused:
            read(text, **options)
        path, _, line = str(refused.value).partition(": ")
        assert path == str(tmp_path / "record.txt") and "\n" not in line and len(line) <= 160, line
        return line

    return refusal


def test_what_is_written_is_read_back_to_the_same_bits(tmp_path):
    rng = np.random.default_rng(1)
    header = {"specimen": "a wall: the second", "synthetic": "yes"}
    written = Record(np.arange(50) / 3, rng.normal(size=50), rng.normal(size=50), header)
    write_record(tmp_path / "record.csv", written)
    back = read_record(tmp_path / "record.csv")
    for name in ("elapsed", "ground_acceleration", "displacement"):
        np.testing.assert_array_equal(getattr(back, name), getattr(written, name))
    assert back.header == header and back.synthetic and len(back.digest) == 64
    assert [path.name for path in tmp_path.iterdir()] == ["record.csv"]


# --- what is read ----------------------------------------------------------------------------------------------------


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
            "ground_acceleration_m_s2,note,elapsed_s\n0,9,0\n.1,9,5e-3\n-.2,9,1e-2\n.3,9,1.5e-2\n0,9,2e-2\n",
            1,
        ),
    ],
)
def test_a_csv_has_separators_line_ends_and_remarks_of_any_program(text, factor, read):
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
        (SHARED + "NPTS= 5, DT= .005\n0 .1 -.2 .3 0", G),
        (ROTATED + "5 .005 NPTS, DT \n0 .1 -.2 .3 0", G),
    ],
)
def test_an_at2_file_is_known_by_npts_and_dt_and_is_in_the_unit_that_it_states(text, factor, read):
    record = read(text)
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * factor, rtol=1e-15)
    assert record.step == 0.005 and record.header["source"].startswith(text.partition("\n")[0])


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("0\n.1\n-.2\n.3\n0\n", STEP_AND_UNIT),
        ("0,.1,-.2,\n.3,0,\n", STEP_AND_UNIT),
        ("300 points, no more\nThe units are (g)\n*** Begin ***\n0 .1 -.2\n.3 0\n", STEP_AND_UNIT),
        ("     0.00E+00     1.00D-01    -2.00e-01\r\n     3.00E-01     0\r\n", STEP_AND_UNIT),
        ("5\n0 .1 -.2 .3 0\n", STEP_AND_UNIT),
        ("Title\n5 .005\n0\n.1\n-.2\n.3\n0\n# the end\n", {"unit": "g"}),
        ("t a\n0 0\n.005 .1\n.010 -.2\n.015 .3\n.020 0\n", {"unit": "g"}),
        ("t;a\n0;0\n.005;.1\n.010;-.2\n.015;.3\n.020;0\n", STEP_AND_UNIT),
        (at2("The units are those of the logger"), {"unit": "g"}),
    ],
)
def test_plain_numbers_are_read_with_a_step_and_a_unit(text, options, read):
    record = read(text, **options)
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * G, rtol=1e-15)
    assert record.step == pytest.approx(0.005, rel=1e-12)


@pytest.mark.parametrize(
    ("step", "times", "printed"),
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
def test_times_that_a_logger_rounded_or_cut_off_are_uniform(step, times, printed, read):
    record = read(csv(times, printed))
    assert record.elapsed.size == 2000
    assert record.step == pytest.approx(step, rel=1e-3)


@pytest.mark.parametrize("printed", ["{:.3f}", "{!r}"])
def test_200_000_samples_are_read_at_once(printed, read):
    text = csv(np.arange(200_000) / 128, printed)
    start = time.process_time()
    assert read(text).elapsed.size == 200_000
    assert (
        time.process_time() - start < 2
    )  # 0.8 alone; processes that share a processor slow each other


# --- what is refused -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("times", "printed", "parts"),
    [
        (
            np.delete(0.01 * N, 1000),
            "{:.2f}",
            ["from 9.99 to 10.01", "1 sample is missing after 9.99"],
        ),
        (
            np.delete(N / 240, [900, 901, 902]),
            "{:.3f}",
            ["to 3.763", "3 samples are missing after 3.746"],
        ),
        (np.delete(N / 60, 1000), "{:.2f}", ["1 sample is missing after 16.65"]),
        (np.delete(N, 700), "{:d}", ["from 699.0 to 701.0", "1 sample is missing after 699.0"]),
        (np.insert(0.01 * N, 5, 0.04), "{:.2f}", ["from 0.04 to 0.04"]),
        (np.r_[0, 1, 3, 2, 4:100] * 0.01, "{:.2f}", ["from 0.01 to 0.03"]),
        (np.r_[0.01 * N[:100], 1.0035 + 0.01 * N[:100]], "{:.4f}", ["elapsed"]),
        (0.01 * N[::-1], "{:.2f}", ["from 19.99 to 19.98"]),
        (0.01 * N * (1 + N * 1e-6), "{:.6f}", ["elapsed"]),
        (1e-5 * N * (1 + N * 1e-6), "{:.4e}", ["elapsed"]),
        (0.01 * N + 0.002 * (N == 50), "{:.3f}", ["elapsed"]),
    ],
)
def test_a_gap_a_double_or_a_swap_is_named_with_its_place(times, printed, parts, message):
    refused = message(csv(times, printed))
    assert all(part in refused for part in parts), refused


@pytest.mark.parametrize(
    ("text", "options", "parts"),
    [
        ("", {}, ["numbers"]),
        ("elapsed_s,ground_acceleration_m_s2\n", {}, ["numbers"]),
        ("elapsed_s,ground_acceleration_m_s2\n0,0\n", {}, ["1 samples"]),
        ("elapsed_s,displacement_m\n0,1\n1,2\n", {}, ["elapsed_s, displacement_m"]),
        (
            "elapsed_s,ground_acceleration_m_s2,ground_acceleration_g\n0,1,1\n1,2,2\n",
            {},
            ["columns"],
        ),
        (
            f"elapsed_s,{','.join(f'channel_{k}' for k in range(20))}\n0{',1' * 20}\n",
            {},
            ["elapsed_s, channel_0"],
        ),
        (CSV + "0.04\n", {}, ["line 7 is '0.04'"]),
        (CSV + "0.04,1,2\n", {}, ["line 7"]),
        (CSV + "0.04,nan\n", {}, ["line 7"]),
        (CSV + "Mean,0.1\n", {}, ["line 7"]),
        (CSV.replace(",", ";").replace(".", ","), {}, ["line 3 is '0,005;0,1'"]),
        (CSV, {"step": 0.01}, ["step is 0.01", "0.005"]),
        (CSV, {"unit": "g"}, ["unit"]),
        (CSV, {"unit": "cm"}, ["unit is 'cm'"]),
        ("# synthetic: perhaps\n" + CSV, {}, ["synthetic is 'perhaps'"]),
        (CSV.encode("utf-16"), {}, ["0xff", "line 1"]),
        ("# Universit\xe9\n".encode("latin-1") + CSV.encode(), {}, ["0xe9", "line 1"]),
        (at2("The units are those of the logger"), {}, ["unit"]),
        (at2("VELOCITY TIME SERIES IN UNITS OF CM/S"), {"unit": "g"}, ["VELOCITY"]),
        (at2("Displacement (CM)"), {"unit": "g"}, ["Displacement"]),
        (at2("ACCELERATION IN CM/S/S (G)"), {}, ["unit"]),
        (at2(count="NPTS= 6, DT= .005"), {}, ["5", "6"]),
        (at2(), {"unit": "cm/s2"}, ["unit"]),
        (at2(), {"step": 0.01}, ["step is 0.01", "0.005"]),
        (at2().replace(".1D0 -2E-1", "0.1E-01-0.2E-01"), {}, ["line 5 is '.0 0.1E-01-0.2E-01"]),
        (
            "0 .1 -.2 .3 0\n",
            {},
            ["(0, 0.1, -0.2, ...)", "step", "unit", "elapsed_s, ground_acceleration_m_s2"],
        ),
        ("0 .1 -.2 .3 0\n", {"step": 0.01}, ["unit"]),
        ("5 .005\n0 .1 -.2 .3 0\n", {"step": 0.01, "unit": "g"}, ["step is 0.01", "0.005"]),
        (
            "0 0\n.005 .1\n.02 -.2\n.025 .3\n.03 0\n",
            STEP_AND_UNIT,
            ["from 0.005 to 0.02", "2 samples are missing"],
        ),
        (
            "".join(f"{k} {k % 3}\n" for k in [*range(20), 21, 20, *range(22, 40)]),
            STEP_AND_UNIT,
            ["from 19.0 to 21.0"],
        ),
        ("t N E\n0 0 0\n.005 .1 .2\n.01 -.2 .1\n", STEP_AND_UNIT, ["3 columns"]),
        ("0,000\n0,125\n-0,250\n", STEP_AND_UNIT, ["point"]),
        ("0 .1\n", {"step": 0, "unit": "g"}, ["elapsed"]),
    ],
)
def test_what_is_no_record_is_refused_in_one_line(text, options, parts, message):
    refused = message(text, **options)
    assert all(part in refused for part in parts), refused


ROWS = " 0.1 0.2 0.3\n-0.1 0.0 0.4\n"
FORMATS = {
    "GeoNet": f"Corrected accelerogram\nSite X\nAcceleration: mm/s/s\n 0 0 0\n{ROWS}Velocity: mm/s\n{ROWS}",
    "AFAD": f"PLACE : X\nSAMPLE INTERVAL (sec.) : 0.01\nNUMBER OF DATA : 6\n\n N-S E-W U-D\n{ROWS}",
    "SMC": f"2 CORRECTED ACCELEROGRAM\n*\nStation X\n 1 2 3\n 1.7e+38 2.0e+02 3.0\n| a comment\n{ROWS}",
    "COSMOS": f"Uncorrected acceleration\n 100 Integers follow\n 1 2\n 100 Reals follow\n{ROWS}",
    "K-NET": "Origin Time 2011\nSampling Freq(Hz) 100Hz\nScale Factor 7845(gal)/8223790\nMemo.\n 1234567 7654321\n",
    "ESM": "SAMPLING_INTERVAL_S: 0.005\nNDATA: 2\nUNITS: cm/s^2\n0.012345678\n-0.012345678\n",
}


@pytest.mark.parametrize("name", FORMATS)
def test_a_format_that_is_not_read_is_refused_with_the_columns_that_are(name, message):
    assert "elapsed_s, ground_acceleration_m_s2" in message(FORMATS[name])


@pytest.mark.parametrize(
    ("changes", "name"),
    [
        ({"elapsed": [0, 0.01, 0.0312]}, "elapsed"),
        ({"elapsed": [0]}, "elapsed"),
        ({"ground_acceleration": [0, 1]}, "ground_acceleration"),
        ({"ground_acceleration": [0, np.nan, 0]}, "ground_acceleration"),
        ({"displacement": [[0, 1, 0]]}, "displacement"),
        ({"header": {"synthetic": "no doubt"}}, "synthetic"),
    ],
)
def test_arrays_that_are_no_record_are_refused_by_name(changes, name):
    with pytest.raises(InputError, match=name):
        Record(**{"elapsed": [0.0, 0.01, 0.02], "ground_acceleration": [0, 1, 0]} | changes)


@pytest.mark.parametrize(("tail", "zeros"), [(0, 0), (0.02, 2), (0.021, 3)])
def test_the_rest_is_at_least_as_long_as_it_must_be(tail, zeros):
    assert append_rest(np.array([1.0, -2.0]), 0.01, tail).tolist() == [1, -2] + [0] * zeros
    with pytest.raises(InputError, match="tail"):
        append_rest(np.ones(2), 0.01, -1)

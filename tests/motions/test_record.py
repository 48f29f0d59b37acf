"""Files of records: which are read, to which numbers, and which are refused where."""

import time

import numpy as np
import pytest

from rockdamp.constants import STANDARD_GRAVITY as G
from rockdamp.errors import InputError
from rockdamp.motions.record import Record, append_rest, read_record, write_record

CSV = "elapsed_s,ground_acceleration_m_s2\n0,0\n0.01,1.5\n0.02,-1\n0.03,0\n"
AT2 = "PEER\nSomewhere, 090\n{unit}\n{count}\n .0 .1D0 -2E-1 .3\n.0\n"
G_UNIT, NPTS = "ACCELERATION TIME SERIES IN UNITS OF G", "NPTS=   5, DT=   .0050 SEC,"
VALUES = [0, 0.1, -0.2, 0.3, 0]


@pytest.fixture
def read(tmp_path):
    def reader(text, name="record.txt", **options):
        path = tmp_path / name
        path.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_record(path, **options)

    return reader


def csv(times, printed="{:g}", column="ground_acceleration_m_s2"):
    rows = "".join(f"{printed.format(time)},{index % 7 - 3}\n" for index, time in enumerate(times.tolist()))
    return f"elapsed_s,{column}\n{rows}"


# --- this project's CSV ----------------------------------------------------------------------------------------------


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


@pytest.mark.parametrize(
    "text",
    [
        CSV,
        "\ufeff# units: s, m s-2\n#\n" + CSV,
        CSV.replace("\n", "\r\n"),
        CSV.replace(",", ";"),
        CSV.replace(",", "\t"),
        CSV.replace("0.01", '"0.01"') + "\n\n# the end\n",
        "ground_acceleration_m_s2,note,elapsed_s\n0,9,0\n1.5,9,0.01\n-1,9,0.02 # here\n0,9,0.03\n",
    ],
)
def test_separators_line_ends_and_remarks_are_those_of_any_program(text, read):
    record = read(text)
    assert record.ground_acceleration.tolist() == [0, 1.5, -1, 0]
    assert (record.step, record.displacement, record.synthetic) == (0.01, None, False)


@pytest.mark.parametrize(("unit", "factor"), [("g", G), ("cm_s2", 0.01), ("m_s2", 1)])
def test_a_column_has_its_unit(unit, factor, read):
    record = read(CSV.replace("m_s2", unit))
    np.testing.assert_allclose(record.ground_acceleration, np.array([0, 1.5, -1, 0]) * factor, rtol=1e-15)


@pytest.mark.parametrize(
    ("text", "part"),
    [
        ("", "no numbers"),
        ("elapsed_s,ground_acceleration_m_s2\n", "no numbers"),
        ("elapsed_s,displacement_m\n0,1\n1,2\n", "columns are elapsed_s, displacement_m"),
        ("elapsed_s,ground_acceleration_m_s2,ground_acceleration_g\n0,1,1\n1,2,2\n", "columns are"),
        (CSV + "0.04\n", "line 6 is '0.04'"),
        (CSV + "0.04,1,2\n", "line 6"),
        (CSV + "0.04,nan\n", "line 6"),
        (CSV + "0.04,1e\n", "line 6"),
        (CSV.replace(",", ";").replace(".", ","), "line 3 is '0,01;1,5'"),
        (CSV + "Mean,0.1\n", "line 6"),
        (
            f"elapsed_s,{','.join(f'channel_{k}' for k in range(20))}\n0{',1' * 20}\n",
            "columns are elapsed_s, channel_0",
        ),
        ("# synthetic: perhaps\n" + CSV, "synthetic is 'perhaps'"),
        ("elapsed_s,ground_acceleration_m_s2\n0,0\n", "1 samples"),
        (CSV.encode("utf-16"), "byte 0xff on line 1"),
        ("# Universit\xe9\n".encode("latin-1") + CSV.encode(), "byte 0xe9 on line 1"),
    ],
)
def test_what_is_no_record_is_refused_in_one_line(text, part, read, tmp_path):
    with pytest.raises(InputError) as refused:
        read(text)
    message = str(refused.value)
    assert message.startswith(f"{tmp_path / 'record.txt'}: ") and part in message
    assert "\n" not in message and len(message) - len(str(tmp_path / "record.txt: ")) <= 160


# --- times -----------------------------------------------------------------------------------------------------------

N = np.arange(2000)


@pytest.mark.parametrize(
    ("step", "text"),
    [
        (1 / 128, csv(N / 128, "{:.3f}")),
        (1 / 128, csv(np.floor(N / 128 * 1000) / 1000, "{:.3f}")),
        (1 / 240, csv(N / 240, "{:.3f}")),
        (1 / 60, csv(N / 60, "{:.2f}")),
        (1 / 256, csv(N / 256, "{:.5f}")),
        (0.005, csv(1.7e9 + 0.005 * N, "{:.3f}")),
        (0.005, csv(1.7e9 + 0.005 * N, "{:.6f}")),
        (0.05, csv(0.05 * N, "{:g}")),
        (0.005, csv(0.005 * N, "{:.3e}")),
        (0.01, csv(np.cumsum(np.full(2000, 0.01)), "{!r}")),
        (0.005, csv((0.005 * N).astype(np.float32).astype(float), "{:.17g}")),
    ],
)
def test_times_that_a_logger_rounded_or_cut_off_are_uniform(step, text, read):
    record = read(text)
    assert record.elapsed.size == 2000
    assert record.step == pytest.approx(step, rel=1e-3)


@pytest.mark.parametrize(
    ("text", "parts"),
    [
        (csv(np.delete(0.01 * N, 1000), "{:.2f}"), ["from 9.99 to 10.01", "1 sample is missing after 9.99"]),
        (csv(np.delete(N / 240, [900, 901, 902]), "{:.3f}"), ["to 3.763", "3 samples are missing after 3.746"]),
        (csv(np.delete(N / 60, 1000), "{:.2f}"), ["1 sample is missing after 16.65"]),
        (csv(np.delete(N, 700), "{:d}"), ["from 699.0 to 701.0", "1 sample is missing after 699.0"]),
        (csv(np.insert(0.01 * N, 5, 0.04), "{:.2f}"), ["from 0.04 to 0.04"]),
        (csv(np.r_[0, 1, 3, 2, 4:100] * 0.01, "{:.2f}"), ["from 0.01 to 0.03"]),
        (csv(np.r_[0.01 * N[:100], 1.0035 + 0.01 * N[:100]], "{:.4f}"), ["must rise by equal steps"]),
        (csv(0.01 * N[::-1], "{:.2f}"), ["from 19.99 to 19.98"]),
        (csv(0.01 * N * (1 + N * 1e-6), "{:.6f}"), ["must rise by equal steps"]),
    ],
)
def test_a_gap_a_double_or_a_swap_is_named_with_its_place(text, parts, read):
    with pytest.raises(InputError) as refused:
        read(text)
    assert all(part in str(refused.value) for part in parts), str(refused.value)


# --- AT2 of PEER -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("unit", "factor"),
    [
        (G_UNIT, G),
        ("ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.1 Hz LP=30.0 Hz", G),
        ("ACCELERATION (G)", G),
        ("ACCELERATION IN CM/S/S", 0.01),
        ("UNITS: CM/SEC**2", 0.01),
        ("ACCELERATION (M/S**2)", 1),
        ("Units are cm / sec / sec", 0.01),
        ("IN GAL", 0.01),
    ],
)
def test_an_at2_file_is_in_the_unit_that_it_states(unit, factor, read):
    record = read(AT2.format(unit=unit, count=NPTS), "renamed.dat")
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * factor, rtol=1e-15)
    assert record.step == 0.005 and "Somewhere" in record.header["source"]


# Heads of files that programs share: NPTS and DT on lines 4, 4, 7 and 7, and a unit in words.
HEADS = [
    f"A QUAKE 1/1/90 0000, SOMEWHERE, NS\nPACIFIC\n{G_UNIT}. FILTER POINTS: HP=0.2 Hz LP=40.0 Hz\nNPTS=  5, dt= .00500",
    "Data of one component\n8 points across in a row\nThe units are (g)\nNPTS= 5, DT= .00500 SEC",
    "Data\n5 points\nPoints in 8F10.5, 8 across in\na row\nThe units are (g)\n** Begin **\nNPTS= 5, DT= .00500 SEC",
    "PEER filename\n H1: 10/15/79, 000\n H2\n angle -37.0\n azimuth = 233.0\n Acceleration in g\n5 0.0050 NPTS, DT ",
]


@pytest.mark.parametrize("head", HEADS)
def test_heads_of_files_that_programs_share_are_read(head, read):
    record = read(f"{head}\n   .0000000E+00   .1000000E+00  -.2000000E+00\n 0.3\n0 \n", "motion.acc")
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * G, rtol=1e-15)
    assert record.step == 0.005


@pytest.mark.parametrize(
    "count", ["NPTS=5, DT= .005", "NPTS 5 DT 5.0D-3 SEC", "DT=0.005 NPTS=5", "5 .005 NPTS, DT", " .005  5  DT, NPTS"]
)
def test_npts_and_dt_stand_in_any_order_and_line(count, read):
    for text in (AT2, "PEER\n{count}\n{unit}\n.0 .1\n-.2 .3 .0\n"):
        if text is AT2 or "DT" in count:
            record = read(AT2.format(unit=G_UNIT, count=count))
            assert (record.step, record.elapsed.size) == (0.005, 5)
    early = read(f"PEER {G_UNIT}\n{count}\n.0 .1\n-.2 .3 .0\n")
    np.testing.assert_allclose(early.ground_acceleration, np.array(VALUES) * G, rtol=1e-15)


@pytest.mark.parametrize(
    ("changes", "options", "part"),
    [
        ({"unit": "The units are those of the logger"}, {}, "unit must be given"),
        ({"unit": "VELOCITY TIME SERIES IN UNITS OF CM/S"}, {"unit": "g"}, "VELOCITY"),
        ({"unit": "Displacement (CM)"}, {"unit": "g"}, "Displacement"),
        ({"count": "NPTS= 6, DT= .005"}, {}, "has 5 accelerations; it must have 6"),
        ({}, {"unit": "cm/s2"}, "unit"),
        ({}, {"unit": "cm"}, "unit is 'cm'"),
        ({}, {"step": 0.01}, "step is 0.01; it must be 0.005"),
    ],
)
def test_an_at2_file_that_contradicts_itself_or_what_is_given_is_refused(changes, options, part, read):
    with pytest.raises(InputError, match=part.replace("'", ".")):
        read(AT2.format(**{"unit": G_UNIT, "count": NPTS} | changes), **options)


def test_numbers_that_run_together_are_named_with_their_line(read):
    with pytest.raises(InputError, match="line 5 is '0.1E-01-0.2E-01"):
        read(f"PEER\n\n{G_UNIT}\nNPTS=2, DT=.01\n0.1E-01-0.2E-01\n")


# --- plain numbers ---------------------------------------------------------------------------------------------------

GIVEN = {"step": 0.005, "unit": "g"}


@pytest.mark.parametrize(
    ("text", "options"),
    [
        ("0\n.1\n-.2\n.3\n0\n", GIVEN),
        ("300 points, no more\nThe units are (g)\n*** Begin ***\n0 .1 -.2\n.3 0\n", GIVEN),
        ("5\n0 .1 -.2 .3 0\n", GIVEN),
        ("5 .005\n0 .1 -.2 .3 0\n", {"unit": "g"}),
        ("Title\n5 .005\n0\n.1\n-.2\n.3\n0\n# the end\n", GIVEN),
        ("     0.00E+00     1.00D-01    -2.00e-01\r\n     3.00E-01     0\r\n", GIVEN),
        ("t a\n0 0\n.005 .1\n.010 -.2\n.015 .3\n.020 0\n", {"unit": "g"}),
        ("t;a\n0;0\n.005;.1\n.010;-.2\n.015;.3\n.020;0\n", GIVEN),
    ],
)
def test_plain_numbers_are_read_with_a_step_and_a_unit(text, options, read):
    record = read(text, **options)
    np.testing.assert_allclose(record.ground_acceleration, np.array(VALUES) * G, rtol=1e-15)
    assert record.step == pytest.approx(0.005, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "options", "parts"),
    [
        ("0 .1 -.2 .3 0\n", {}, ["(0, 0.1, -0.2, ...)", "step and unit", "elapsed_s, ground_acceleration_m_s2"]),
        ("0 .1 -.2 .3 0\n", {"step": 0.01}, ["unit must be given"]),
        ("5 .005\n0 .1 -.2 .3 0\n", {"step": 0.01, "unit": "g"}, ["step is 0.01; it must be 0.005"]),
        ("0 0\n.005 .1\n.02 -.2\n.025 .3\n.03 0\n", GIVEN, ["from 0.005 to 0.02", "2 samples are missing"]),
        ("t N E\n0 0 0\n.005 .1 .2\n.01 -.2 .1\n", GIVEN, ["3 columns", "elapsed_s, ground_acceleration_m_s2"]),
        ("0,000\n0,125\n-0,250\n", GIVEN, ["a point"]),
        ("0 .1\n", {"step": 0, "unit": "g"}, ["elapsed"]),
    ],
)
def test_plain_numbers_without_what_they_need_are_refused(text, options, parts, read):
    with pytest.raises(InputError) as refused:
        read(text, **options)
    assert all(part in str(refused.value) for part in parts), str(refused.value)


ROWS = " 0.1 0.2 0.3\n-0.1 0.0 0.4\n"
OF_NETWORKS = {
    "GeoNet": f"Corrected accelerogram\nSite X\nAcceleration: mm/s/s\n 0 0 0\n{ROWS}Velocity: mm/s\n{ROWS}",
    "AFAD": f"PLACE : X\nSAMPLE INTERVAL (sec.) : 0.01\nNUMBER OF DATA : 6\n\n N-S E-W U-D\n{ROWS}",
    "SMC": f"2 CORRECTED ACCELEROGRAM\n*\nStation X\n 1 2 3\n 1.7e+38 2.0e+02 3.0\n| a comment\n{ROWS}",
    "COSMOS": f"Uncorrected acceleration\n 100 Integers follow\n 1 2\n 100 Reals follow\n{ROWS}",
    "K-NET": "Origin Time 2011\nSampling Freq(Hz) 100Hz\nScale Factor 7845(gal)/8223790\nMemo.\n 1234567 7654321\n",
    "ESM": "SAMPLING_INTERVAL_S: 0.005\nNDATA: 2\nUNITS: cm/s^2\n0.012345678\n-0.012345678\n",
}


@pytest.mark.parametrize("network", OF_NETWORKS)
def test_a_format_that_is_not_read_is_refused_with_the_columns_that_are(network, read, tmp_path):
    with pytest.raises(InputError, match="elapsed_s, ground_acceleration_m_s2") as refused:
        read(OF_NETWORKS[network])
    assert len(str(refused.value)) - len(str(tmp_path / "record.txt: ")) <= 160


@pytest.mark.parametrize("printed", ["{:.3f}", "{!r}"])
def test_200_000_samples_take_less_than_a_second(printed, read):
    text = csv(np.arange(200_000) / 128, printed)
    start = time.process_time()
    assert read(text).elapsed.size == 200_000
    assert time.process_time() - start < 2  # 0.8 alone; processes that share a processor slow each other


# --- arrays ----------------------------------------------------------------------------------------------------------


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

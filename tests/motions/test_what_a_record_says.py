"""What the file of a record says of itself, its units above all, is believed or refused, never passed over."""

import numpy as np
import pytest

from rockdamp import units
from rockdamp.errors import InputError
from rockdamp.motions.records import Record, read_record, write_record
from rockdamp.vocabulary import STANDARD_GRAVITY

ROWS = "0,0.5\n0.01,-1.5\n0.02,0.25\n"
SI = "elapsed_s,ground_acceleration_m_s2\n" + ROWS
VALUES = np.array([0.5, -1.5, 0.25])
AT2 = "PEER\nSomewhere, 90\n{third}\n{fourth}\n .5 -1.5\n .25\n"
THIRD, FOURTH = "ACCELERATION TIME SERIES IN UNITS OF G", "NPTS=   3, DT=   .0050 SEC"


@pytest.fixture
def read(tmp_path):
    def read(text, name="record.csv"):
        path = tmp_path / name
        path.write_text(text, encoding="utf-8")
        return read_record(path)

    return read


@pytest.fixture
def at2(read):
    return lambda third=THIRD, fourth=FOURTH: read(AT2.format(third=third, fourth=fourth), "record.AT2")


# --- units of a CSV


@pytest.mark.parametrize(
    ("column", "unit", "factor"),
    [
        ("ground_acceleration_m_s2", "m/s^2", 1.0),
        ("ground_acceleration_g", "g", STANDARD_GRAVITY),
        ("ground_acceleration_cm_s2", "cm s-2", 0.01),
        ("ground_acceleration_cm_s2", "Gal", 0.01),
    ],
)
def test_a_column_of_another_unit_becomes_si_and_the_header_may_say_so(read, tmp_path, column, unit, factor):
    text = SI.replace("ground_acceleration_m_s2", column)
    np.testing.assert_allclose(read(text).ground_acceleration, VALUES * factor, rtol=1e-15)
    record = read(f"# units: s, {unit}\n{text}")
    np.testing.assert_allclose(record.ground_acceleration, VALUES * factor, rtol=1e-15)
    write_record(tmp_path / "again.csv", record)  # in SI, and says so
    again = read_record(tmp_path / "again.csv")
    np.testing.assert_array_equal(again.ground_acceleration, record.ground_acceleration)


def test_displacements_stay_in_metres_beside_an_acceleration_in_g(read):
    record = read("# units: s, g, m\nelapsed_s,ground_acceleration_g,displacement_m\n0,1,2\n1,0,3\n")
    assert record.displacement.tolist() == [2, 3]
    assert record.header["units"] == "s, m s-2, m"


@pytest.mark.parametrize("stated", ["s, g", "s, m s-2, mm", "ms, m s-2", "SI"])
def test_units_that_are_not_those_of_the_columns_are_refused(read, stated):
    with pytest.raises(InputError, match="the numbers are taken in s, m s-2 and m: ground_acceleration_m_s2 is in"):
        read(f"# units: {stated}\n{SI}")


def test_two_columns_of_acceleration_are_refused(read):
    with pytest.raises(InputError, match="columns ground_acceleration_g and ground_acceleration_m_s2 on line 1 state"):
        read("elapsed_s,ground_acceleration_g,ground_acceleration_m_s2\n0,0,0\n1,1,1\n")


def test_a_record_made_in_python_states_no_other_units(read):
    with pytest.raises(InputError, match="has 'g'; the numbers are taken in s, m s-2 and m: they must be converted"):
        Record([0, 1], [0, 1], header={"Units": "s, g"})


@pytest.mark.parametrize(
    ("text", "value"),
    [
        *((text, 1e-2) for text in ("cm/s2", "CM/SEC2", "CM/S**2", "cm/sec^2", "cm/s/s", "CM / SEC / SEC", "cm s-2")),
        *((text, 1e-2) for text in ("gal", "Gals", "cm s^-2", "cm·s⁻²", "cm/s²", "cm/(s^2)", "cm*s**-2", "cm.s-2")),
        *((text, 0.0254) for text in ("IN/SEC2", "in/s/s", "inches/sec**2")),
        *((text, 1.0) for text in ("M/S/S", "m s-2", "m/s2")),
        *((text, STANDARD_GRAVITY) for text in ("G", " g ")),
        *((text, pytest.approx(STANDARD_GRAVITY / 100, rel=1e-15)) for text in ("%g", "% g")),
        *((text, None) for text in ("m", "s", "m/s", "cm/s3", "mg", "%", "N", "", "cm2/s2", "m/mm2", "cm/s-2")),
    ],
)
def test_a_unit_of_acceleration_is_known_in_any_usual_form_and_nothing_else_is(text, value):
    assert units.size(text, "m s-2") == value


# --- units of AT2


@pytest.mark.parametrize(
    ("third", "factor"),
    [
        ("ACCELERATION TIME SERIES IN UNITS OF G", STANDARD_GRAVITY),
        ("ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: HP=0.05 Hz LP=50.0 Hz", STANDARD_GRAVITY),
        ("ACCELERATION TIME SERIES", STANDARD_GRAVITY),
        ("ACCELERATION TIME SERIES, UNITS: CM/S2", 0.01),
        ("ACCELERATION TIME SERIES IN CM / SEC / SEC", 0.01),
        ("ACCELERATION TIME SERIES IN GALS", 0.01),
        ("ACCELERATION TIME SERIES IN M/S/S", 1.0),
        ("ACCELERATION IN UNITS OF IN/SEC2", 0.0254),
        ("ACCELERATION IN CM PER SEC PER SEC", None),  # understood or refused, and refused is as good
        ("VELOCITY TIME SERIES IN UNITS OF CM/S", None),
        ("DISPLACEMENT TIME SERIES", None),
    ],
)
def test_an_at2_file_is_in_the_unit_that_it_states_or_refused(at2, third, factor):
    if factor is None:
        with pytest.raises(InputError, match=r"units are|line 3 is"):
            at2(third)
    else:
        np.testing.assert_allclose(at2(third).ground_acceleration, VALUES * factor, rtol=1e-15)


@pytest.mark.parametrize(
    ("fourth", "step"),
    [
        ("NPTS= 3, DT= 1.0D-02", 0.01),
        ("NPTS= 3, DT= 5. MSEC", 0.005),
        ("NPTS= 3, DT= .0050SEC,", 0.005),
        ("3 0.005 NPTS, DT (SEC)", 0.005),
        ("NPTS= 3, DT= 1/200", None),
    ],
)
def test_the_step_of_an_at2_file_is_read_whole_or_refused(at2, fourth, step):
    if step is None:
        with pytest.raises(InputError, match="on line 4|line 4 is"):
            at2(fourth=fourth)
    else:
        assert at2(fourth=fourth).step == pytest.approx(step, rel=1e-12)


# --- the header


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ("# synthetic: yes\n# synthetic: no\n", "key 'synthetic' on line 2 stands there more than once"),
        ("# synthetic = yes\n", "line 1 is '# synthetic = yes'; it must be '# synthetic: ...', with a colon"),
        ("# a synthetic motion\n", "line 1 is '# a synthetic motion'"),
        ("# sythetic: yes\n", "key 'sythetic' on line 1 is unknown; did you mean 'synthetic'?"),
        ("# pulse period: 2\n", "did you mean 'pulse_period'?"),
        ("# synthetic: true\n", "synthetic is 'true'; it must be yes or no"),
    ],
)
def test_a_header_that_could_be_misread_is_refused(read, lines, message):
    with pytest.raises(InputError) as caught:
        read(lines + SI)
    assert message in str(caught.value)

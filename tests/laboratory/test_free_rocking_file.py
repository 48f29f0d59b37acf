"""Files of free-rocking tests: read as sensors and videos write them, or refused in one line."""

import re

import numpy as np
import pytest

import rockdamp as rd

HEADER = "# specimen: a block\n# synthetic: yes\n"
ROWS = "0.0,0.05\n0.002,0.0499\n0.004,0.0495\n"
TIMES = [0, 0.002, 0.004]
VALUES = [0.05, 0.0499, 0.0495]
VIDEO = {"frame_rate": 500, "pixel": 0.001}


@pytest.fixture
def read(tmp_path):
    def read_text(text, **options):
        path = tmp_path / "test.csv"
        path.write_bytes(text.encode())
        return rd.read_free_rocking(path, **options)

    return read_text


# --- columns and rows -----------------------------------------------------------------------------


FILES = {
    "documented columns": f"{HEADER}elapsed_s,displacement_m\n{ROWS}",
    "no heads": ROWS,
    "title": f"Displacement of wall 3\n{ROWS.replace(',', ' ')}",
    "Windows": f"\ufefft,x\n{ROWS}".replace(",", ";").replace("\n", "\r\n"),
    "tabs and quotes": f'"Time (s)"\t"x (m)"\n{ROWS}'.replace(",", "\t"),
    "units and blanks": "mass A\nt [ms]  x [mm]\n0 50\n2   49.9\n4 4.95e1\n",
    "empty last column": "t_ms,x_mm,note\n0,50,\n2,49.9,\n4,49.5,\n",
    "names that are not documented": f"x,t\n{ROWS}",
    # Named columns stand anywhere.
    "index of pandas": (",elapsed_s,displacement_m\n0,0,0.05\n1,0.002,0.0499\n2,0.004,0.0495\n"),
    "index twice": "Unnamed: 0,elapsed_ms,displacement_mm\n0,0,50\n1,2,49.9\n2,4,49.5\n",
    "any order": "displacement [mm],note,Elapsed [ms]\n50,held,0\n49.9,,2\n49.5,,4\n",
    "index, other names": ",t,x\n0,0,0.05\n1,0.002,0.0499\n2,0.004,0.0495\n",
    # Rows without a value are skipped.
    "gaps": "t,x,y\n0,0.05,a\n0.001,,b\n0.002,0.0499,\n0.003,NaN,\n0.004,0.0495,# c\n\n",
    "gap between blanks": "t x\n0 0.05\n0.001\n0.002 0.0499\n0.004 0.0495\n",
    "gap in the first row": "t_ms,x_mm\n-2,\n0,50\n2,49.9\n4,49.5\n",
}


@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_file_has_times_and_displacements(text, read):
    test = read(text)
    np.testing.assert_allclose(test.elapsed, TIMES, rtol=1e-12)
    np.testing.assert_allclose(test.displacement, VALUES, rtol=1e-12)
    assert test.rotation is None


@pytest.mark.parametrize(
    "text",
    [
        "frame,x\n0,50\n1,49.9\n2,49.5\n",
        "frame,x [px]\n0,50\n1,49.9\n2,49.5\n",
        "elapsed_s,displacement_px,frame,displacement\n9,9,0,50\n9,9,1,49.9\n9,9,2,49.5\n",
    ],
    ids=["first two columns", "unit of pixels", "named columns"],
)
def test_video_has_frames_and_pixels(text, read):
    test = read(text, **VIDEO)
    np.testing.assert_allclose([test.elapsed, test.displacement], [TIMES, VALUES], rtol=1e-12)


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("rotation_rad", 1),
        ("rotation_deg", np.pi / 180),
        ("angle [deg]", np.pi / 180),
        ("theta (deg)", np.pi / 180),
        ("a [mrad]", 1e-3),
    ],
)
def test_angles_are_rotations(head, factor, read):
    test = read(f"t,{head}\n{ROWS}")
    np.testing.assert_allclose(test.rotation, factor * np.array(VALUES), rtol=1e-12)


@pytest.mark.parametrize("name", ["angle", "Theta", "rotation", "rot_x", "φ", "lower tilt"])
@pytest.mark.parametrize("options", [{}, {"pixel": 0.001}], ids=["", "pixel"])
def test_angle_without_a_unit_is_refused(name, options, read):
    message = re.escape(f"column '{name}' has no unit; write {name} [rad] or {name} [deg]")
    with pytest.raises(rd.InputError, match=message):
        read(f"t,{name}\n{ROWS}", **options)


@pytest.mark.parametrize("name", ["x", "prototype", "position", "displacement", "u_hinge"])
def test_other_names_without_a_unit_are_displacements_in_metres(name, read):
    test = read(f"t,{name}\n{ROWS}")
    np.testing.assert_array_equal(test.displacement, VALUES)
    assert test.columns == f"t [s assumed], {name} [m assumed]"


@pytest.mark.parametrize(
    ("text", "options", "columns"),
    [
        (f"elapsed_s,displacement_m\n{ROWS}", {}, "elapsed_s, displacement_m"),
        (f"t [s],theta (deg)\n{ROWS}", {}, "t[s], theta(deg)"),
        (ROWS, {}, "column 1 [s assumed], column 2 [m assumed]"),
        ("frame,x\n0,50\n1,49.9\n2,49.5\n", VIDEO, "frame, x"),
    ],
    ids=["units", "brackets", "no heads", "video"],
)
def test_columns_are_stated_with_their_units(text, options, columns, read):
    assert read(text, **options).columns == columns


def test_header_describes_the_test(read):
    test = read(f"{HEADER}elapsed_s,displacement_m\n{ROWS}")
    assert test.header["specimen"] == "a block"
    assert test.synthetic


def test_without_a_header_a_test_counts_as_measured(read):
    assert not read(ROWS).synthetic


# --- files that are refused -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "options", "named"),
    [
        ("", {}, "no rows"),
        ("t,x\n", {}, "no rows"),
        ("elapsed_s,displacement_m\n", {}, "no rows"),
        ("t,x\n0,0.05\n", {}, "number of samples is 1"),
        (f"{HEADER}t,x\n0,1\n0.1,x\n", {}, "line 5 is '0.1,x'"),
        ("t,x\n0,1\n0.1,1,5\n", {}, "line 3"),
        ("time,x\n12:00:01.5,1\n12:00:01.6,1\n", {}, "line 2 is '12:00:01.5,1'"),
        ("t,x\n0,1\n0.2,2\n0.1,2\n", {}, "from 0.2 to 0.1"),
        ("t,x\n0,1\n0.1,2\n0.1,2\n", {}, "from 0.1 to 0.1"),
        ("index,t,x\n0,0,1\n1,0.1,1\n", {}, "step is 1 s"),
        ("index,elapsed_s,x\n0,0,1\n1,0.1,1\n", {}, "columns are index, elapsed_s, x"),
        ("t,x [px]\n0,1\n0.1,2\n", {}, "px"),
        ("x_m,t_s\n1,0\n1,0.1\n", {}, "unit of 'x_m'"),
        ("t,displacement_deg\n0,1\n0.1,1\n", {}, "unit of 'displacement_deg'"),
        ("elapsed_s,elapsed_ms,displacement_m\n0,0,1\n", {}, "2 columns elapsed"),
        ("elapsed_s,displacement_m,displacement_m\n0,1,1\n", {}, "2 columns displacement"),
        ("elapsed_s,displacement_m,rotation_rad\n0,1,1\n", {}, "a displacement and a rotation"),
        ("t,x\n0,1\n0.1,2\n", {"frame_rate": 30}, "frame is 0.1"),
        ("t,x\n0,1\n1,2\n", {"frame_rate": 0}, "frame_rate"),
        ("t,x\n0,1\n1,2\n", {"pixel": -1}, "pixel"),
        (f"# synthetic: perhaps\n{ROWS}", {}, "synthetic"),
    ],
)
def test_unusable_file_is_refused_in_one_line(text, options, named, read, tmp_path):
    with pytest.raises(rd.InputError) as refusal:
        read(text, **options)
    message = str(refusal.value)
    assert message.startswith(f"{tmp_path / 'test.csv'}: ")
    assert named in message
    assert "\n" not in message


@pytest.mark.parametrize(
    "text",
    [
        "elapsed_s;displacement_m\n0;0\n0,002;0,05\n",
        "t;x\n0,00;0,05\n0,01;0,05\n",
        "t x\n0,00 0,05\n0,01 0,05\n",
        "elapsed_s,displacement_m\n0,000,0,05\n0,002,0,05\n",
        "0,000,0,05\n0,002,0,05\n",
    ],
)
def test_decimal_comma_is_named(text, read):
    with pytest.raises(rd.InputError, match=r"line \d is .*the decimal sign must be a point"):
        read(text)


def test_one_measured_series_is_required():
    with pytest.raises(rd.InputError, match="displacement or a rotation"):
        rd.FreeRocking([0.0, 0.1])


def test_series_have_one_length():
    with pytest.raises(rd.InputError, match="has shape"):
        rd.FreeRocking([0.0, 0.1], np.zeros(3))


@pytest.mark.parametrize("step", [9e-5, 0.11])
def test_impossible_step_is_refused(step):
    with pytest.raises(rd.InputError, match="step is"):
        rd.FreeRocking(step * np.arange(3), np.zeros(3))

"""Files of free-rocking tests: read as they say, refused where they say something else."""

import numpy as np
import pytest

import rockdamp as rd

HEADER = "# specimen: a block\n# synthetic: yes\n"
ROWS = "0.0,0.05\n0.002,0.0499\n0.004,0.0495\n"


@pytest.mark.parametrize(("column", "name"), [("displacement_m", "displacement"), ("rotation_rad", "rotation")])
def test_a_file_is_read(tmp_path, column, name):
    path = tmp_path / "test.csv"
    path.write_text(f"{HEADER}elapsed_s,{column}\n{ROWS}", encoding="utf-8")
    test = rd.read_free_rocking(path)
    assert getattr(test, name).tolist() == [0.05, 0.0499, 0.0495] and test.synthetic
    assert test.header["specimen"] == "a block" and test.step == pytest.approx(0.002)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "columns are"),
        (f"{HEADER}elapsed_s,displacement_m,rotation_rad\n0,1,2\n", "columns are"),
        (f"{HEADER}elapsed_s,displacement_m\n0,1\n0.1,x\n", "line 5"),
        (f"{HEADER}elapsed_s,displacement_m\n0,1\n0.1,2\n0.2,2\n0.4,2\n0.5,1\n", "missing after 0.2"),
        ("# synthetic: perhaps\nelapsed_s,displacement_m\n" + ROWS, "synthetic is 'perhaps'"),
    ],
)
def test_a_file_that_is_none_is_refused_with_its_line(tmp_path, text, said):
    path = tmp_path / "test.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(rd.InputError) as refused:
        rd.read_free_rocking(path)
    assert str(refused.value).startswith(f"{path}: ") and said in str(refused.value)


def test_it_has_a_displacement_or_a_rotation_and_nothing_else():
    with pytest.raises(rd.InputError, match="one of displacement_m and rotation_rad"):
        rd.FreeRocking([0.0, 0.1])
    with pytest.raises(rd.InputError, match="has shape"):
        rd.FreeRocking([0.0, 0.1], np.zeros(3))

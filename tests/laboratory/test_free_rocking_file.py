"""Files of free-rocking tests: read as sensors and videos write them, refused where they contradict themselves."""

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.solvers.exact import exact_history

HEADER = "# specimen: a block\n# synthetic: yes\n"
ROWS = "0.0,0.05\n0.002,0.0499\n0.004,0.0495\n"
TIMES, VALUES = [0, 0.002, 0.004], [0.05, 0.0499, 0.0495]


@pytest.fixture
def read(tmp_path):
    def reader(text, **options):
        path = tmp_path / "test.csv"
        path.write_bytes(text.encode())
        return rd.read_free_rocking(path, **options)

    return reader


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (f"{HEADER}elapsed_s,displacement_m\n{ROWS}", {}),
        (ROWS, {}),
        (f"Release\n{ROWS}", {}),
        (f"\ufefft;x\r\n{ROWS}".replace(",", ";").replace("\n", "\r\n"), {}),
        (f'"Time (s)"\t"x (m)"\n{ROWS}'.replace(",", "\t"), {}),
        ("mass A\nt [ms]  x [mm]\n0 50\n2   49.9\n4 4.95e1\n", {}),
        (
            "t,x,note\n0,0.05,held\n0.001,,lost\n0.002,0.0499,\n0.003,NaN,\n0.004,0.0495,# end\n\n",
            {},
        ),
        ("t x\n0 0.05\n0.001\n0.002 0.0499\n0.004 0.0495\n", {}),
        ("frame,x\n0,50\n1,49.9\n2,49.5\n", {"frame_rate": 500, "pixel": 0.001}),
        ("frame,x [px]\n0,50\n1,49.9\n2,49.5\n", {"frame_rate": 500, "pixel": 0.001}),
    ],
)
def test_the_first_two_columns_are_times_and_displacements(text, options, read):
    test = read(text, **options)
    np.testing.assert_allclose([test.elapsed, test.displacement], [TIMES, VALUES], rtol=1e-12)
    assert test.rotation is None and test.synthetic == ("synthetic" in text)
    assert test.header.get("specimen", "a block") == "a block"


@pytest.mark.parametrize(
    ("head", "factor"), [("rotation_rad", 1), ("theta (deg)", np.pi / 180), ("a [mrad]", 1e-3)]
)
def test_a_column_in_a_unit_of_angles_is_a_rotation(head, factor, read):
    test = read(f"t,{head}\n{ROWS}")
    np.testing.assert_allclose(test.rotation, factor * np.array(VALUES), rtol=1e-12)


@pytest.mark.parametrize(
    ("text", "options", "part"),
    [
        ("", {}, "has no rows"),
        ("t,x\n", {}, "has no rows"),
        (f"{HEADER}t,x\n0,1\n0.1,x\n", {}, "line 5 is '0.1,x'"),
        ("t,x\n0,1\n0.1,1,5\n", {}, "line 3"),
        ("t;x\n0;0\n0,002;0,05\n", {}, "line 3"),
        ("0,000,0,05\n0,002,0,05\n", {}, "from 0 to 0"),
        ("t,x\n0,1\n0.2,2\n0.1,2\n", {}, "from 0.2 to 0.1"),
        ("t,x\n0,1\n0.1,2\n0.1,2\n", {}, "from 0.1 to 0.1"),
        ("t,x [px]\n0,1\n0.1,2\n", {}, "px"),
        ("t,x\n0,1\n0.1,2\n", {"frame_rate": 30}, "frame is 0.1"),
        ("t,x\n0,1\n1,2\n", {"frame_rate": 0}, "frame_rate"),
        ("t,x\n0,1\n1,2\n", {"pixel": -1}, "pixel"),
        (f"# synthetic: perhaps\n{ROWS}", {}, "synthetic"),
    ],
)
def test_a_file_that_is_none_is_refused_in_one_line(text, options, part, read, tmp_path):
    with pytest.raises(rd.InputError) as refused:
        read(text, **options)
    message = str(refused.value)
    assert (
        message.startswith(f"{tmp_path / 'test.csv'}: ") and part in message and "\n" not in message
    )


def test_a_test_has_a_displacement_or_a_rotation_of_as_many_samples_as_times():
    with pytest.raises(rd.InputError, match="displacement or a rotation"):
        rd.FreeRocking([0.0, 0.1])
    with pytest.raises(rd.InputError, match="has shape"):
        rd.FreeRocking([0.0, 0.1], np.zeros(3))


# --- times that are not uniform --------------------------------------------------------------------------------------

WALL = rd.Wall(thickness=0.25, height=3.0, hinge_ratio=0.6)
U_INS, P = float(WALL.instability_displacement), float(WALL.frequency_parameter)
TRUE = 0.05, 0.8, 0.86  # a1, b1, e
FRAMES = np.arange(420) / 60


def release(elapsed, printed="{:.6f},{:.6f}"):
    """The file of a release, held for half a second, by the event-driven solver."""
    free = elapsed[elapsed >= 0.5] - 0.5
    moved = exact_history(
        rd.TrilinearCurve(*TRUE[:2]), rd.Damping("CR", TRUE[2]), P * free, release_amplitude=0.5
    )
    displacement = U_INS * np.concatenate(
        [np.full(elapsed.size - free.size, 0.5), moved.displacement]
    )
    shown = displacement + 2e-4 * np.random.RandomState(1).standard_normal(elapsed.size)
    return [printed.format(time, value) for time, value in zip(elapsed, shown, strict=True)]


@pytest.mark.parametrize(
    "rows",
    [
        release(FRAMES, "{:.2f},{:.4f}"),
        release(np.cumsum(np.random.RandomState(3).choice([0.8, 1, 1, 1.6], 400)) / 60),
        release(np.delete(FRAMES, [*range(90, 95), *range(200, 205)])),
        [
            row if index % 25 else row.partition(",")[0] + ","
            for index, row in enumerate(release(FRAMES))
        ],
    ],
    ids=["rounded", "variable rate", "five frames lost", "rows without a value"],
)
def test_uneven_times_are_fitted_as_they_are(rows, read):
    fit = rd.fit_free_rocking(read("t,x\n" + "\n".join(rows)), WALL)
    error = np.abs(fit["estimate"].values - TRUE)
    assert (error < [5e-4, 5e-3, 2e-3]).all() and (error < 4 * fit["standard_error"].values).all()


def test_a_gap_that_hides_an_impact_is_refused_with_its_place(read):
    rows = release(np.delete(FRAMES, range(78, 93)))
    with pytest.raises(rd.InputError, match="gap after 1.28"):
        rd.fit_free_rocking(read("t,x\n" + "\n".join(rows)), WALL)

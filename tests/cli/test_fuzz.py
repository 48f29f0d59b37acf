"""The command line under whatever is typed: a result, or an error of ours with status 2; never a traceback."""

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import example, given, settings
from hypothesis import strategies as st

from rockdamp.cli import main

# A doubt about a record is printed, and is no failure.
pytestmark = pytest.mark.filterwarnings("ignore::rockdamp.errors.RecordWarning")

NUMBERS = st.one_of(
    st.floats(0.01, 0.99).map(repr),
    st.floats(allow_nan=True, allow_infinity=True).map(repr),
    st.integers(-3, 30).map(str),
    st.sampled_from(["0", "-0.0", "1", "nan", "inf", "-inf", "1e308", "1e-308", "5e-324", "1e400", "0x10", "1_0", "٣"]),
)
UNITS = st.sampled_from(
    ["mm", "m", "s", "kg", "t/m^3", "ft", "degC", "m^2", "m**-1", "/m", "m/", "m*", "dB", "%", "e", "delta_degF", "m m"]
)
QUANTITIES = st.one_of(NUMBERS, st.tuples(NUMBERS, UNITS).map("".join), st.text(max_size=8))
RANGES = st.one_of(
    NUMBERS,
    st.lists(NUMBERS, min_size=2, max_size=4).map(":".join),
    st.lists(NUMBERS, min_size=2, max_size=3).map(",".join),
    st.sampled_from(["0.8:0.95:0.05", "1e999999999:1e999999999:1", "0:1:1e-999999999", "::", ",", "sNaN:1:1"]),
    st.text(max_size=8),
)
FLOATS = st.one_of(NUMBERS, st.text(max_size=5))
MODELS = st.sampled_from(["CR", "CDC", "cdr", "SDR", "ECD", "POWER", ""])


def options(**strategies):
    """Some of the options, each with a text of its strategy."""
    pairs = {f"--{name.replace('_', '-')}": strategy for name, strategy in strategies.items()}
    return st.fixed_dictionaries({}, optional=pairs).map(
        lambda found: [part for pair in found.items() for part in pair]
    )


WALL = options(
    thickness=QUANTITIES,
    height=QUANTITIES,
    width=QUANTITIES,
    density=QUANTITIES,
    hinge_ratio=FLOATS,
    overburden_ratio=FLOATS,
    eccentricity=QUANTITIES,
)
CURVE = options(a1=FLOATS, b1=FLOATS, a3=FLOATS, softening=st.sampled_from(["steeper", "translated", "x"]))


def check(arguments):
    result = CliRunner().invoke(main, [*arguments, "--json"])
    assert result.exception is None or isinstance(result.exception, SystemExit), (arguments, result.exc_info)
    if result.exit_code:
        assert result.exit_code == 2 and result.stdout == "", (arguments, result.stdout)
        assert any(line.startswith("Error: ") for line in result.stderr.splitlines()), (arguments, result.stderr)
    assert result.exit_code in (0, 2), arguments
    if result.exit_code == 2:
        assert result.stdout == "" and "Error:" in result.stderr
        return
    for number in numbers(json.loads(result.stdout, parse_constant=pytest.fail)):
        assert np.isfinite(number)


def numbers(value):
    """All numbers in what JSON holds."""
    if isinstance(value, (dict, list)):
        for part in value.values() if isinstance(value, dict) else value:
            yield from numbers(part)
    elif isinstance(value, float):
        yield value


@settings(max_examples=150)
@given(WALL, CURVE, options(amplitude=RANGES))
@example(["--thickness", "0.3", "--height", "4.5"], [], ["--amplitude", "1e-300"])
@example(["--thickness", "1e-200", "--height", "1e-200"], [], [])
@example(["--thickness", "5e-324", "--height", "4.5"], [], [])
def test_wall_never_ends_in_a_traceback(wall, curve, amplitude):
    check(["wall", "--thickness", "0.3", "--height", "4.5", *wall, *curve, *amplitude])


@settings(max_examples=60)
@given(RANGES, CURVE, options(release=FLOATS, response_length=st.one_of(FLOATS, st.floats(1, 20).map(repr))))
@example("5e-324", [], [])
@example("1e-5", [], [])
@example("0.9999999999999999", [], [])
@example("0.85", ["--a1", "0.1499999999999", "--b1", "0.85"], [])
@example("0.85", ["--a1", "5e-324"], [])
@example("0.85", ["--b1", "5e-324"], [])
@example("0.85", [], ["--release", "5e-324"])
@example("0.85", [], ["--release", "0.9999999999999999"])
@example("0.85", [], ["--response-length", "1e308"])
def test_equivalent_never_ends_in_a_traceback(restitution, curve, others):
    check(["equivalent", "--restitution", restitution, "--a1", "0.05", "--b1", "0.7", *curve, *others])


@settings(max_examples=60)
@given(
    CURVE,
    options(damping_model=MODELS, damping_ratio=FLOATS, restitution=FLOATS, release=FLOATS, length=QUANTITIES),
    WALL,
)
@example([], ["--damping-model", "CDC", "--damping-ratio", "1e308"], [])
@example([], ["--damping-model", "ECD", "--damping-ratio", "1e308"], [])
@example([], ["--damping-model", "SDR", "--damping-ratio", "1e160"], [])
@example([], ["--damping-model", "CR", "--restitution", "5e-324"], [])
@example([], ["--damping-model", "CR", "--restitution", "0.9", "--length", "5e-324"], [])
def test_decay_never_ends_in_a_traceback(curve, others, wall):
    check(["decay", "--a1", "0.05", "--b1", "0.7", *curve, *others, *wall])


@pytest.fixture(scope="module")
def record(tmp_path_factory):
    path = tmp_path_factory.mktemp("fuzz") / "record.csv"
    rows = "\n".join(f"{0.02 * i:.2f},{np.sin(i / 5):.4f}" for i in range(40))
    path.write_text(f"elapsed_s,ground_acceleration_m_s2\n{rows}\n", encoding="utf-8")
    return path


@settings(max_examples=60)
@given(WALL, options(damping_model=MODELS, damping_ratio=FLOATS, restitution=FLOATS, scale=FLOATS, tail=QUANTITIES))
@example([], ["--damping-model", "CDR", "--damping-ratio", "0.05", "--scale", "1e308"])
@example([], ["--damping-model", "CDR", "--damping-ratio", "1e300", "--scale", "1e300"])
@example([], ["--damping-model", "CR", "--restitution", "1", "--tail", "5e-324"])
def test_respond_never_ends_in_a_traceback(record, wall, others):
    common = ["--record", str(record), "--thickness", "0.3", "--height", "4.5", "--preset", "moderate"]
    check(["respond", *common, *wall, *others])


@settings(max_examples=100)
@given(st.binary(max_size=200), st.sampled_from(["record.csv", "record.AT2"]))
@example(b"elapsed_s,ground_acceleration_m_s2\n0,1e308\n1e-300,1e308\n", "record.csv")
@example(b"elapsed_s,ground_acceleration_m_s2\n0,1\n1e300,1\n", "record.csv")
@example(b"elapsed_s,ground_acceleration_m_s2\n0,1\n1e-300,1\n", "record.csv")
@example(b"elapsed_s,ground_acceleration_m_s2\n-1e308,1\n1e308,1\n", "record.csv")
@example(b"a\nb\nUNITS OF G\nNPTS= 2, DT= 1e308\n1 2\n", "record.AT2")
@example(b"a\nb\nUNITS OF G\nNPTS= 999999999999999999999, DT= 1\n1 2\n", "record.AT2")
def test_no_record_ends_in_a_traceback(tmp_path_factory, content, name):
    path = Path(tmp_path_factory.getbasetemp()) / name
    path.write_bytes(content)
    wall = ["--thickness", "0.3", "--height", "4.5", "--overburden-ratio", "1"]
    check(["respond", "--record", str(path), *wall, "--preset", "new", "--damping-model", "CR", "--restitution", "0.9"])
    check(["calibrate", "--record", str(path), *wall])

"""The example of overturned boulders, on a made-up folder of the layout of the campaign."""

import numpy as np
import pandas as pd
import pytest
from peers import example
from scipy.integrate import solve_ivp

boulders = example(".", "boulders")

ANGLE = 0.11  # of the made-up boulder [rad]
FREQUENCY_PARAMETER = 3.6  # of the same [rad/s]
RATE = 800  # samples of the table in a second
DURATIONS = np.geomspace(0.2, 1.6, 10)  # of the pulses; each is one record [s]
AMPLITUDES = np.geomspace(0.12, 1.2, 12)  # of its scalings [g]


def block_overturns(acceleration, step, restitution, coefficient=0.0):
    """Whether the made-up boulder overturns, by SciPy's solver with events."""
    p = FREQUENCY_PARAMETER
    times = step * np.arange(acceleration.size)
    load = acceleration / ANGLE
    now, velocity, side = 0.0, 0.0, 0.0
    while now < times[-1]:
        if side == 0:
            lifted = np.flatnonzero((np.abs(load) > 1) & (times >= now))
            if lifted.size == 0:
                return False
            now = times[lifted[0]]
            side = -np.sign(load[lifted[0]])

        def rates(time, state, side=side):
            x, v = state
            return [v, p**2 * (x - side - np.interp(time, times, load)) - coefficient * p * v]

        def impact(time, state, side=side):
            return side * state[0] + 1e-9

        def overturned(time, state):
            return abs(state[0]) - 1

        impact.terminal = overturned.terminal = True
        impact.direction = -1
        motion = solve_ivp(
            rates,
            (now, times[-1]),
            [0.0, velocity],
            events=(impact, overturned),
            max_step=0.01,
            rtol=1e-7,
        )
        if motion.t_events[1].size:
            return True
        now = motion.t[-1]
        velocity = restitution * motion.y[1, -1]
        side = np.sign(velocity)
        if abs(velocity) < 0.01 * p and abs(np.interp(now, times, load)) <= 1:
            velocity, side = 0.0, 0.0
    return False


def pulse(duration, amplitude, rate=RATE):
    """Acceleration of one cycle of a sine after half a second of rest [g]."""
    elapsed = np.arange(3 * rate) / rate - 0.5
    inside = (elapsed >= 0) & (elapsed <= duration)
    return amplitude * np.sin(2 * np.pi * elapsed / duration) * inside


@pytest.fixture(scope="module")
def campaign(tmp_path_factory):
    """The clone of a repository with 120 tests of one boulder, and one file that is too large."""
    clone = tmp_path_factory.mktemp("clone")
    folder = clone / boulders.FOLDER
    folder.mkdir(parents=True)
    elapsed = np.arange(3 * RATE) / RATE
    restitution = boulders.housner_restitution(ANGLE)
    rows = []
    for record, duration in enumerate(DURATIONS):
        for amplitude in AMPLITUDES:
            number = 11 + len(rows)
            acceleration = pulse(duration, amplitude)
            outcome = block_overturns(acceleration[::4], 4 / RATE, restitution)
            pgv = 9.80665 * amplitude * duration / np.pi
            rows.append(
                [number, f" 'RSN{record}_A.xlsx'", pgv / amplitude / 9.80665, amplitude, outcome]
            )
            channels = np.column_stack(
                [elapsed, acceleration + 0.013] * 2
            )  # an offset of the sensor
            header = "Time [s] - Plot 0\tAmplitude - Plot 0"
            path = folder / f"Test{number:03}.txt"
            np.savetxt(path, channels, fmt="%g", delimiter="\t", header=header, comments="")
    with (folder / "Test012.txt").open("ab") as file:
        file.truncate(boulders.LARGEST_FILE + 1)
    numbers, records, ratios, accelerations, outcomes = zip(*rows, strict=True)
    information = pd.DataFrame(
        {
            "Test No. ": numbers,
            "Ground Motion": records,
            "PGV/PGA": ratios,
            "Scaled PGA (g)": accelerations,
        }
    )
    information.to_excel(folder / "Earthquake_Records_Info.xlsx", startrow=1, index=False)
    results = {"Test Number": numbers}
    for specimen in (1, 2):
        name = f"Experimental Results for response-Specimen {specimen}"
        results[name] = np.array(outcomes, dtype=int)
        results[f"Specimen {specimen}-Numerical KN=1 KS=1"] = np.array(outcomes, dtype=int)
    pd.DataFrame(results).to_excel(folder / "Results_Granite.xlsx", index=False)
    return clone


@pytest.fixture(scope="module")
def contents(campaign):
    """Tests, motions and their number, as the example reads them."""
    return boulders.read_campaign(campaign)


def test_motions_lose_offset_and_keep_pulse(contents):
    tests, motions, number = contents
    assert number == 120
    assert 12 not in tests.index
    acceleration, step = motions[tests.index.get_loc(11 + 12 * 9)]
    assert step == pytest.approx(4 / RATE)
    np.testing.assert_allclose(acceleration, pulse(1.6, 0.12)[::4], atol=0.002)


def test_scalings_of_a_station_are_one_record(contents):
    tests, _, _ = contents
    assert tests["record"].value_counts().to_dict()["RSN3"] == AMPLITUDES.size


def test_fit_recovers_the_block_of_the_outcomes(contents):
    tests, motions, _ = contents
    shares = boulders.share_overturned(boulders.rigid_blocks, motions)
    outcome = tests["Experimental Results for response-Specimen 1"].to_numpy() == 1
    angle, frequency_parameter, _ = boulders.likeliest_block(shares, outcome)
    assert angle == pytest.approx(ANGLE, rel=0.06)
    assert frequency_parameter == pytest.approx(FREQUENCY_PARAMETER, rel=0.09)


@pytest.mark.parametrize(
    ("restitution", "coefficient"), [(0.9, 0.0), (1.0, 0.2)], ids=["impacts", "coefficient"]
)
def test_block_overturns_as_by_another_solver(restitution, coefficient):
    seed = np.random.default_rng(3)
    waves = seed.normal(size=(40, 5)) @ [pulse(t, 1.0, 200) for t in (0.3, 0.5, 0.8, 1.2, 1.9)]
    scale = np.geomspace(0.08, 0.6, 40)
    motions = waves / np.abs(waves).max(axis=1, keepdims=True) * scale[:, None]
    step = 1 / 200
    by_events = [
        boulders.overturns(motion / ANGLE, step * FREQUENCY_PARAMETER, restitution, coefficient)
        for motion in motions
    ]
    expected = [block_overturns(motion, step, restitution, coefficient) for motion in motions]
    assert 5 < np.sum(expected) < 35
    assert by_events == expected


def test_fits_never_see_the_record_they_predict():
    records = np.array(["a", "a", "b", "c", "c"])

    def fit(training):
        unseen = set(records[~training])
        assert len(unseen) == 1
        assert unseen.isdisjoint(records[training])
        return np.where(training, np.nan, 0.3)

    assert boulders.cross_validate(fit, records).tolist() == [0.3] * 5


def test_program_prints_a_row_for_each_model(campaign, contents, monkeypatch, capsys):
    tests, motions, number = contents
    few = slice(0, None, 3)  # for speed; every record keeps four scalings
    few_contents = tests.iloc[few], motions[few], number
    monkeypatch.setattr(boulders, "read_campaign", {campaign: few_contents}.get)
    monkeypatch.setattr(boulders, "RESTITUTIONS", (0.98,))
    monkeypatch.setattr(boulders, "COEFFICIENTS", (0.05,))
    monkeypatch.setattr(boulders, "YIELD_DISPLACEMENT_RATIOS", (0.02,))
    boulders.main(campaign)
    printed = capsys.readouterr().out
    assert "40 of 120 motions, of 10 records" in printed
    assert printed.count("discrete elements, chosen in training") == 2
    assert printed.count("block, BAND on a curve of a1 = 0.02") == 2


def test_mcnemar_counts_the_pairs_that_differ():
    wrong = np.array([True] * 6 + [False] * 4)
    other_wrong = np.array([True] + [False] * 9)
    assert boulders.mcnemar(wrong, other_wrong) == pytest.approx(2 / 2**5)
    assert boulders.mcnemar(wrong, wrong) == 1


def test_scalings_of_one_record_count_as_one_difference():
    wrong = np.repeat([True, False], 10)
    records = np.repeat(["a", "b"], 10)
    never_wrong = np.zeros(20, dtype=bool)
    assert boulders.mcnemar(wrong, never_wrong) < 0.01
    assert boulders.compare_by_record(wrong, never_wrong, records) == 1

"""Predict which motions of a shaking table overturned two granite boulders.

Run it as `python examples/boulders.py CLONE`, where CLONE is the folder of a clone of
https://github.com/ZhiangChen/virtual_shake_robot_pybullet. It needs the dependency group
`examples`, and prints the tables of `docs/measured.md`.

A boulder is a rigid block on a flat base. In units of its slenderness angle alpha and its
frequency parameter p, between two impacts,

    x'' + c x' - x = -side + a / (g alpha),

with x = rotation / alpha, side = 1 or -1 for the edge that it rocks on, and table acceleration a.
The acceleration is linear between its samples, so the equation has a closed form, and each
lift-off and impact is an event. An impact keeps the part e of the velocity: Housner, The behavior
of inverted pendulum structures during earthquakes, Bulletin of the Seismological Society of
America 53 (1963). The block overturns at x = 1, as a wall collapses at u_ins.
"""

import math
import sys
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pandas as pd
from numba import njit
from scipy.optimize import minimize
from scipy.signal import butter, sosfiltfilt
from scipy.stats import binomtest

import rockdamp as rd

FOLDER = "data/Shake_Table_Response"
LARGEST_FILE = 4 * 2**20  # docs/measured.md has the results of the motions up to this size [bytes]
CORNER = 25.0  # of the low pass, far above the frequencies that can overturn a boulder [Hz]
DECIMATION = 4  # from 800 samples a second, of a motion that has nothing above the corner

ROUNDING = 1e-12  # error of x that counts as none
SLOWEST_IMPACT = 0.01  # a slower block stops: it has 1e-4 of the energy that overturns it [alpha p]

# The angles lie SPACING apart, in logarithm. A boulder's angle is uncertain, as it differs from
# edge to edge: five blocks stand for a boulder, 2 SPACING apart, whose standard deviation is 0.15.
SPACING = 0.15 / math.sqrt(8)
NEIGHBOURS = (-4, -2, 0, 2, 4)
ANGLES = 0.035 * np.exp(SPACING * np.arange(42))  # alpha [rad]
CENTRES = ANGLES[4:-4]
FREQUENCY_PARAMETERS = 2.0 * np.exp(0.08 * np.arange(18))  # p [rad/s]
RESTITUTIONS = (0.5, 0.6, 0.7, 0.8, 0.85, 0.9, 0.95, 0.98, 1.0)
COEFFICIENTS = (0.02, 0.05, 0.1, 0.2, 0.4, 0.8)  # c [p]
YIELD_DISPLACEMENT_RATIOS = (0.02, 0.01)  # a1 of the nearly rigid curves
LAPSE = 0.02  # ASSUME: one outcome in fifty has a cause that no block has

HOUSNER = "block, Housner's e"
FREE_RESTITUTION = "block, e fitted"
FREE_COEFFICIENT = "block, constant coefficient fitted"
REFERENCES = {"Housner's e": HOUSNER, "e fitted": FREE_RESTITUTION}


# --- the files of the repository ------------------------------------------------------------------


def read_motion(path):
    """Return the acceleration of the table [g], filtered and decimated, and the step [s]."""
    columns = pd.read_csv(path, sep=r"\s+", header=None, skiprows=1, usecols=[0, 1])
    elapsed, acceleration = columns.to_numpy(dtype=float).T
    step = (elapsed[-1] - elapsed[0]) / (elapsed.size - 1)
    if np.abs(np.diff(elapsed) - step).max() > step / 2:
        raise ValueError(f"{path}: the times are not uniform")
    low_pass = butter(4, CORNER, fs=1 / step, output="sos")
    # The table starts and ends at rest, so its mean acceleration is the offset of the sensor.
    filtered = sosfiltfilt(low_pass, acceleration - acceleration.mean())
    return filtered[::DECIMATION], step * DECIMATION


def read_tests(folder):
    """Read the tables of tests, one row each: its record, PGA [g], PGV [m/s], and the outcomes."""
    outcomes = pd.read_excel(folder / "Results_Granite.xlsx", index_col="Test Number")
    motions = pd.read_excel(folder / "Earthquake_Records_Info.xlsx", header=1)
    motions = motions.rename(columns=str.strip).set_index("Test No.")
    names = motions["Ground Motion"].str.strip(" '")
    stations = names.str.extract(r"(RSN\d+)", expand=False)  # both horizontal components are one
    pga = motions["Scaled PGA (g)"]
    motions = pd.DataFrame(
        {
            "record": stations.fillna(names),
            "pga": pga,
            "pgv": motions["PGV/PGA"] * pga * 9.80665,
        }
    )
    return outcomes.join(motions, how="inner", validate="one_to_one")


def read_campaign(clone):
    """Return the tests whose motions are available, their motions, and the number of all tests."""
    folder = Path(clone) / FOLDER
    tests = read_tests(folder)
    paths = {number: folder / f"Test{number:03}.txt" for number in tests.index}
    available = [
        number
        for number, path in paths.items()
        if path.exists() and path.stat().st_size <= LARGEST_FILE
    ]
    motions = [read_motion(paths[number]) for number in available]
    return tests.loc[available], motions, len(tests)


# --- the rocking block, from event to event -------------------------------------------------------


@njit
def propagator(coefficient, duration):
    """Return two solutions of y'' + c y' - y = 0 after a duration t, with r^2 = 1 + c^2/4.

    They are exp(-c t/2) sinh(r t)/r and exp(-c t/2) cosh(r t).
    """
    rate = math.sqrt(1.0 + coefficient * coefficient / 4.0)
    decay = math.exp(-coefficient * duration / 2.0)
    odd = decay * math.sinh(rate * duration) / rate
    even = decay * math.cosh(rate * duration)
    return odd, even


@njit
def swing(x, v, side, load, slope, coefficient, duration, solutions):
    """Return x and v after a duration on one edge, under a load of the given slope."""
    odd, even = solutions
    half = coefficient / 2.0
    # x + load - side + c slope solves the equation without a load.
    shift = load - side + coefficient * slope
    y = x + shift
    y_rate = v + slope
    x_end = y * (even + half * odd) + y_rate * odd - shift - slope * duration
    v_end = y * odd + y_rate * (even - half * odd) - slope
    return x_end, v_end


@njit
def impact_time(x, v, side, load, slope, coefficient, latest):
    """Return the time until the block is back at x = 0, by Newton's method within bisection.

    At `latest` the block is already beyond x = 0.
    """
    before = 0.0
    after = latest
    time = latest
    for _ in range(60):
        solutions = propagator(coefficient, time)
        x_now, v_now = swing(x, v, side, load, slope, coefficient, time, solutions)
        if abs(x_now) <= ROUNDING:
            break
        if side * x_now < 0.0:
            after = time
        else:
            before = time
        time -= x_now / v_now if v_now else time
        if not before < time < after:
            time = (before + after) / 2.0
    return time


@njit(nogil=True)
def overturns(load, step, restitution, coefficient):
    """Return whether a block overturns from rest.

    Parameters
    ----------
    load : ndarray, shape (samples,)
        Table acceleration over g alpha. [-]
    step : float
        Time between two samples, times p. [-]
    restitution : float
        Part e of the velocity that an impact keeps. [-]
    coefficient : float
        Damping coefficient c between impacts [p].
    """
    x = 0.0
    v = 0.0
    side = 0.0  # at rest
    whole_step = propagator(coefficient, step)
    for sample in range(load.size - 1):
        slope = (load[sample + 1] - load[sample]) / step
        elapsed = 0.0
        while elapsed < step:
            now = load[sample] + slope * elapsed
            if side == 0.0:
                push = now
                if abs(now) <= 1.0:  # the load lifts the block where it reaches 1 or -1
                    push = slope
                    elapsed += (math.copysign(1.0, slope) - now) / slope if slope else math.inf
                if elapsed < step:
                    side = math.copysign(1.0, push)
                continue
            remaining = step - elapsed
            solutions = whole_step if elapsed == 0.0 else propagator(coefficient, remaining)
            state = swing(x, v, side, now, slope, coefficient, remaining, solutions)
            if side * state[0] >= -ROUNDING:
                x, v = state
                break
            flight = impact_time(x, v, side, now, slope, coefficient, remaining)
            solutions = propagator(coefficient, flight)
            _, v = swing(x, v, side, now, slope, coefficient, flight, solutions)
            v *= restitution
            x = 0.0
            elapsed += flight
            side = math.copysign(1.0, v)
            if abs(v) < SLOWEST_IMPACT and abs(now + slope * flight) <= 1.0:
                v = 0.0
                side = 0.0
        if abs(x) >= 1.0:
            return True
    return False


@njit(nogil=True)
def overturning_blocks(acceleration, step, angles, frequency_parameters, restitutions, coefficient):
    """Return which blocks overturn, shape (angles, frequency parameters)."""
    overturned = np.empty((angles.size, frequency_parameters.size), dtype=np.bool_)
    for row in range(angles.size):
        load = acceleration / angles[row]
        for column in range(frequency_parameters.size):
            dimensionless_step = frequency_parameters[column] * step
            overturned[row, column] = overturns(
                load, dimensionless_step, restitutions[row], coefficient
            )
    return overturned


def housner_restitution(angle):
    """Return e of a block that conserves its moment of momentum at an impact."""
    return 1 - 1.5 * np.sin(angle) ** 2


def rigid_blocks(motion, restitution=None, coefficient=0.0):
    """Return which rigid blocks a motion overturns; e is Housner's unless it is given."""
    acceleration, step = motion
    restitutions = housner_restitution(ANGLES)
    if restitution is not None:
        restitutions = np.full(ANGLES.size, restitution)
    return overturning_blocks(
        acceleration, step, ANGLES, FREQUENCY_PARAMETERS, restitutions, coefficient
    )


def band_blocks(motion, yield_displacement_ratio):
    """Return which blocks with BAND a motion overturns, on a curve that is rigid beyond 2 a1."""
    acceleration, step = motion
    a1 = yield_displacement_ratio
    curve = rd.TrilinearCurve(a1, 1 - 2 * a1)
    damping = rd.Damping.from_restitution(housner_restitution(ANGLES), "BAND")
    overturned = np.empty((ANGLES.size, FREQUENCY_PARAMETERS.size), dtype=bool)
    for column, frequency_parameter in enumerate(FREQUENCY_PARAMETERS):
        sampling = frequency_parameter * step
        substeps = math.ceil(sampling * curve.initial_frequency / 0.1)
        load = rd.Load(acceleration, 1 / ANGLES, sampling, substeps)
        overturned[:, column] = rd.peaks(curve, damping, load=load, threads=1).collapsed
    return overturned


def share_overturned(blocks, motions):
    """Return how many of the five blocks around each angle overturn, shape (motions, angles, p)."""
    with ThreadPoolExecutor() as pool:
        overturned = np.array(list(pool.map(blocks, motions)))
    centres = np.arange(4, ANGLES.size - 4)
    return np.mean([overturned[:, centres + neighbour] for neighbour in NEIGHBOURS], axis=0)


# --- models: a function from the tests to learn from to the probability of each test --------------


def log_probability(probability, outcome):
    """Return the logarithm of the probability of each outcome, by motion first."""
    return np.log(np.where(outcome, probability, 1 - probability))


def fit_grid(training, shares, outcome):
    """Return the probabilities of a grid's likeliest point; shares are of shape (tests, points)."""
    probability = LAPSE + (1 - 2 * LAPSE) * shares
    likelihood = log_probability(probability[training], outcome[training, None]).sum(axis=0)
    return probability[:, likelihood.argmax()]


def fit_logistic(training, features, outcome):
    """Return the probabilities of a logistic regression on features, shape (tests, features)."""
    sign = np.where(outcome, 1.0, -1.0)[training]

    def objective(weights):
        ridge = 1e-3 * np.sum(weights**2)  # bounds the weights where a line parts all outcomes
        return np.logaddexp(0, -sign * (features[training] @ weights)).sum() + ridge

    weights = minimize(objective, np.zeros(features.shape[1]), method="BFGS").x
    return 1 / (1 + np.exp(-features @ weights))


def fit_columns(training, columns, outcome):
    """Return the probabilities of predictions 0 and 1 in training, by the likeliest column."""
    probability = np.empty(columns.shape)
    for column, predicted in enumerate(columns.T):
        for value in (0, 1):
            like = training & (predicted == value)
            frequency = (outcome[like].sum() + 0.5) / (like.sum() + 1)
            probability[predicted == value, column] = frequency
    likelihood = log_probability(probability[training], outcome[training, None]).sum(axis=0)
    return probability[:, likelihood.argmax()]


def cross_validate(fit, records):
    """Return the probability of each test by a fit to the tests of all other records."""
    probability = np.empty(records.size)
    for record in np.unique(records):
        held_out = records == record
        probability[held_out] = fit(~held_out)[held_out]
    return probability


def logistic_features(tests):
    """Return the features of each logistic model: logarithms of PGA and PGV, centred."""
    ln_pga = np.log(tests["pga"] / tests["pga"].median())
    ln_pgv = np.log(tests["pgv"] / tests["pgv"].median())
    one = np.ones(len(tests))
    squares = [ln_pga**2, ln_pga * ln_pgv, ln_pgv**2]
    return {
        "logistic, ln PGV": np.column_stack([one, ln_pgv]),
        "logistic, ln PGA and ln PGV": np.column_stack([one, ln_pga, ln_pgv]),
        "logistic, all quadratic terms": np.column_stack([one, ln_pga, ln_pgv, *squares]),
    }


# --- the tables -----------------------------------------------------------------------------------


def simulate_blocks(motions):
    """Return the shares of overturned blocks of each model, shape (motions, angles, p, ...)."""
    fixed_restitutions = [
        share_overturned(partial(rigid_blocks, restitution=restitution), motions)
        for restitution in RESTITUTIONS
    ]
    constant_coefficients = [
        share_overturned(partial(rigid_blocks, restitution=1.0, coefficient=coefficient), motions)
        for coefficient in COEFFICIENTS
    ]
    shares = {
        HOUSNER: share_overturned(rigid_blocks, motions),
        FREE_RESTITUTION: np.stack(fixed_restitutions, axis=-1),
        FREE_COEFFICIENT: np.stack(constant_coefficients, axis=-1),
    }
    for a1 in YIELD_DISPLACEMENT_RATIOS:
        blocks = partial(band_blocks, yield_displacement_ratio=a1)
        shares[f"block, BAND on a curve of a1 = {a1:g}"] = share_overturned(blocks, motions)
    return shares


def read_outcome(tests, boulder):
    """Return which tests overturned a boulder."""
    return tests[f"Experimental Results for response-Specimen {boulder}"].to_numpy() == 1


def make_fits(tests, shares, boulder):
    """Return for each model the function from training to the probability of each test."""
    outcome = read_outcome(tests, boulder)
    columns = tests.filter(regex=f"^Specimen {boulder}-Numerical").to_numpy()
    fits = {
        model: partial(fit_grid, shares=share.reshape(len(tests), -1), outcome=outcome)
        for model, share in shares.items()
    }
    for model, features in logistic_features(tests).items():
        fits[model] = partial(fit_logistic, features=features, outcome=outcome)
    wrong = (columns != outcome[:, None]).sum(axis=0)
    best_column = columns[:, [wrong.argmin()]]
    fits["discrete elements, chosen in training"] = partial(
        fit_columns, columns=columns, outcome=outcome
    )
    fits["discrete elements, best in hindsight"] = partial(
        fit_columns, columns=best_column, outcome=outcome
    )
    return fits


def mcnemar(wrong, other_wrong):
    """Return the two-sided p value that two models are wrong equally often, by the exact test."""
    first_only = int(np.sum(wrong & ~other_wrong))
    second_only = int(np.sum(other_wrong & ~wrong))
    if first_only + second_only == 0:
        return 1.0
    return binomtest(first_only, first_only + second_only).pvalue


def compare_by_record(wrong, other_wrong, records):
    """Return the two-sided p value of `mcnemar` by a random change of sign of each record.

    The scalings of one record are not independent tests, so they change sign together.
    """
    difference = wrong.astype(int) - other_wrong
    by_record = pd.Series(difference).groupby(records).sum().to_numpy()
    signs = np.random.default_rng(0).choice([-1, 1], size=(20_000, by_record.size))
    as_large = np.abs(signs @ by_record) >= np.abs(by_record.sum())
    return (as_large.sum() + 1) / (as_large.size + 1)


def compare_models(tests, shares, boulder):
    """Return a row a model: wrong outcomes, log-likelihood, and p values against two references.

    Each test is predicted by a fit to all other records.
    """
    outcome = read_outcome(tests, boulder)
    records = tests["record"].to_numpy()
    probabilities = {
        model: cross_validate(fit, records)
        for model, fit in make_fits(tests, shares, boulder).items()
    }
    wrong = {model: (value > 0.5) != outcome for model, value in probabilities.items()}
    rows = {}
    for model, probability in probabilities.items():
        log_likelihood = log_probability(probability, outcome).sum()
        row = {"wrong": wrong[model].sum(), "ln L": log_likelihood}
        for name, reference in REFERENCES.items():
            row[f"p, {name}"] = mcnemar(wrong[model], wrong[reference])
            row[f"by record, {name}"] = compare_by_record(wrong[model], wrong[reference], records)
        rows[model] = row
    return pd.DataFrame.from_dict(rows, orient="index")


def likeliest_block(shares, outcome):
    """Return angle [rad], p [rad/s] and log-likelihood of the block that fits best."""
    probability = LAPSE + (1 - 2 * LAPSE) * shares
    likelihood = log_probability(probability, outcome[:, None, None]).sum(axis=0)
    row, column = np.unravel_index(likelihood.argmax(), likelihood.shape)
    return CENTRES[row], FREQUENCY_PARAMETERS[column], likelihood.max()


def profile(values, shares, outcome):
    """Return a row a value of e or c, the last axis of the shares: the likeliest block with it."""
    rows = {
        value: likeliest_block(shares[..., index], outcome) for index, value in enumerate(values)
    }
    return pd.DataFrame.from_dict(rows, orient="index", columns=["alpha", "p", "ln L"])


def hold_frequency_parameter(shares, outcome):
    """Return the likeliest e by p [rad/s], as if p were known."""
    rows = {}
    for index, frequency_parameter in enumerate(FREQUENCY_PARAMETERS):
        held = profile(RESTITUTIONS, shares[:, :, [index]], outcome)
        rows[round(frequency_parameter, 2)] = held["ln L"].idxmax()
    return pd.Series(rows)


def main(clone):
    """Print the tables."""
    tests, motions, number = read_campaign(clone)
    records = tests["record"].nunique()
    print(f"{len(tests)} of {number} motions, of {records} records\n")
    shares = simulate_blocks(motions)
    for boulder in (1, 2):
        outcome = read_outcome(tests, boulder)
        angle, frequency_parameter, _ = likeliest_block(shares[HOUSNER], outcome)
        print(f"boulder {boulder}, overturned by {outcome.sum()}; predicted from all other records")
        print(compare_models(tests, shares, boulder).to_string(float_format="%.3g"))
        print(f"{HOUSNER}: alpha = {angle:.3f} rad, p = {frequency_parameter:.2f} rad/s\n")
        print(f"boulder {boulder}, the likeliest block of each e and c, from all records")
        print(profile(RESTITUTIONS, shares[FREE_RESTITUTION], outcome).round(3).to_string())
        print(profile(COEFFICIENTS, shares[FREE_COEFFICIENT], outcome).round(3).to_string())
        print("the likeliest e of each p")
        print(hold_frequency_parameter(shares[FREE_RESTITUTION], outcome).to_string(), "\n")


if __name__ == "__main__":
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        sys.exit(__doc__)
    main(sys.argv[1])

"""What a fit leaves of a record, and slips in the record that explain it: checked before anything is sampled."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.integrate import cumulative_trapezoid

from rockdamp.arrays import Array
from rockdamp.errors import InputError
from rockdamp.histories.measured_test import rest_samples
from rockdamp.laboratory.least_squares import Fit, Solution
from rockdamp.mechanics.wall import Parapet, Wall
from rockdamp.motions.records import Record
from rockdamp.plausibility import ACCELERATIONS, LENGTHS, of_motion
from rockdamp.text import listed

# ASSUME: a wall that stands does not go beyond u_ins, where it falls; a sensor's drift and a slack measure may add
# half of that. Tests that restitution explains well leave some per cent of the peak.
FARTHEST = 1.5  # of u_ins
SMALL = 0.005  # of the peak: what less leaves is no doubt
POOR, POOREST = 0.03, 0.10  # of the peak: from the first on slips are looked for, from the second on it is refused
NOISY = 3.0  # times the sensor's noise at rest, which a misfit must exceed besides
BETTER = 3.0  # times smaller is the misfit of a record without its slip
TABLE_DEGREE = 3  # of the polynomial that an integrated acceleration is known but for
CLIPPED = 5  # neighbouring equal samples at an extreme, at least
BESIDE = 2.5  # steps of the logger to the samples beside these, at least
ROUNDING = 1e-9  # of the largest value: a smaller difference is none


@dataclass(frozen=True)
class Misfit:
    """What the best fit leaves of a record: its root mean square [m], over the peak, and over the noise at rest."""

    residual_rms: float
    residual_over_peak: float
    residual_over_noise: float | None  # None of a record without noise

    @classmethod
    def of(cls, solution: Solution) -> Misfit:
        """Return the misfit of a solution."""
        fit = solution.fit
        rms = float(np.sqrt(np.mean(solution.residual**2)))
        peak, noise = float(np.abs(fit.measured).max()), fit.rest_deviation
        return cls(rms, rms / peak, rms / noise if noise > ROUNDING * peak else None)

    @property
    def variables(self) -> dict[str, float]:
        """The three numbers as a dataset has them; NaN for none."""
        noise = self.residual_over_noise
        return {
            "residual_rms": self.residual_rms,
            "residual_over_peak": self.residual_over_peak,
            "residual_over_noise": np.nan if noise is None else noise,
        }

    def __str__(self) -> str:
        noise = self.residual_over_noise
        over_noise = "" if noise is None else f", {noise:.3g} times the sensor's noise at rest"
        return f"{1000 * self.residual_rms:.3g} mm, {100 * self.residual_over_peak:.2g} % of the peak{over_noise}"

    @property
    def doubts(self) -> list[str]:
        """A warning if the best fit leaves more than the sensor's noise."""
        return (
            [f"the best fit leaves {self}: errors tell what holds under this model alone"]
            if self.exceeds(SMALL)
            else []
        )

    def exceeds(self, share: float) -> bool:
        """Return True if the misfit is more than a share of the peak, and more than noise."""
        noise = self.residual_over_noise
        return self.residual_over_peak > share and (noise is None or noise > NOISY)


def require_possible(record: Record, wall: Wall | Parapet) -> None:
    """Raise `InputError` for a displacement that no wall comes back from, with the slip that it looks like."""
    if record.displacement is None:
        return  # the fit refuses it
    u_ins = float(np.max(wall.instability_displacement))
    peak, moved = (
        float(np.abs(column - column[0]).max()) for column in (record.displacement, record.ground_acceleration)
    )
    if peak == 0:
        raise InputError("the measured displacement is constant; it must be that of a wall that rocks")
    if peak <= FARTHEST * u_ins:
        return
    stated = f"the largest measured displacement is {peak:.4g} m, {peak / u_ins:.3g} times u_ins = {u_ins:.4g} m"
    asked = [f"was it in {name}" for name, size in LENGTHS.items() if 0.01 < peak * size / u_ins <= 1]
    if moved <= FARTHEST * u_ins and not of_motion(peak):
        asked = ["were its column and that of the acceleration exchanged"]
    raise InputError(f"{stated}, beyond which the wall falls{_ask(asked)}")


def require_explained(solution: Solution) -> Misfit:
    """Return the misfit of the best fit, or raise `InputError` with the slip that the record looks like.

    Where the misfit is far above the noise, the record without each possible slip is fitted too.
    """
    misfit = Misfit.of(solution)
    stated = f"the best fit leaves {misfit}"
    clipped = list(_clipped(solution.fit.record)) if misfit.exceeds(SMALL) else []
    if clipped:
        raise InputError(f"{stated}{_ask(clipped)}")
    if not misfit.exceeds(POOR):
        return misfit
    tried: dict[str, Misfit] = {}
    for words, corrected in slips(solution.fit):
        with suppress(InputError):
            tried[words] = Misfit.of(corrected.solution())
    words, better = min(tried.items(), key=lambda item: item[1].residual_over_peak, default=("", misfit))
    if BETTER * better.residual_over_peak < misfit.residual_over_peak:
        raise InputError(f"{stated}. If {words}, it leaves {better}: is that so?")
    if misfit.exceeds(POOREST):
        most = f"it must leave at most {100 * POOREST:.2g} % of the peak"
        raise InputError(f"{stated}; {most}. It fits no better if {listed(list(tried))}")
    return misfit


def slips(fit: Fit) -> Iterator[tuple[str, Fit]]:
    """Yield what may be wrong with a record, in words, and the fit of the record without it."""
    record = fit.record
    yield "the sign of the acceleration is wrong", _of(fit, ground_acceleration=-record.ground_acceleration)
    for word, displaced in (("not subtracted from", -1.0), ("added to", 1.0)):
        relative = _shown(record) + displaced * table_displacement(record)
        yield (
            f"the table's displacement is {word} the wall's",
            replace(_of(fit, displacement=relative), trend_degree=TABLE_DEGREE),
        )
    peak = float(np.abs(record.ground_acceleration).max())
    for unit, size in ACCELERATIONS.items():
        if size != 1 and not of_motion(size * peak):
            scaled = size * record.ground_acceleration
            yield f"the acceleration is in {unit}", _of(fit, ground_acceleration=scaled)


def table_displacement(record: Record) -> Array:
    """Integrate the ground acceleration, less its mean at rest, twice; it starts at rest. [m]"""
    acceleration = record.ground_acceleration - record.ground_acceleration[: rest_samples(record)].mean()
    velocity = cumulative_trapezoid(acceleration, dx=record.step, initial=0)
    return np.asarray(cumulative_trapezoid(velocity, dx=record.step, initial=0))


def _shown(record: Record) -> Array:
    """Return the displacement as the sensor shows it, which a record that is fitted has. [m]"""
    assert record.displacement is not None
    return record.displacement


def _of(fit: Fit, **changed: Any) -> Fit:
    """Return the fit of a record with other channels."""
    record = replace(fit.record, **changed)
    return replace(fit, record=record).with_motion(record.ground_acceleration)


def _clipped(record: Record) -> Iterator[str]:
    """Yield the channels of which neighbouring samples at an extreme are equal, in words."""
    for name, values in (("displacement", _shown(record)), ("acceleration", record.ground_acceleration)):
        for extreme in (values.max(), values.min()):
            count = _cut_off(values, extreme)
            if count:
                yield f"is the {name} clipped, of which {count} neighbouring samples are all {extreme:.4g}"
                break


def _cut_off(values: Array, extreme: float) -> int:
    """Count the neighbouring samples at an extreme if they cut the channel off; 0 where its top is round.

    Steps of a logger make the top of a slow motion flat too; but the samples beside it are then one step away.
    """
    edges = np.flatnonzero(np.diff(np.concatenate([[False], values == extreme, [False]])))
    start, end = max(edges.reshape(-1, 2), key=lambda run: run[1] - run[0])
    beside = [values[at] for at in (start - 1, end) if 0 <= at < values.size]
    differences = np.abs(np.diff(values))
    logger = float(differences[differences > ROUNDING * np.abs(values).max()].min(initial=np.inf))
    cut = end - start >= CLIPPED and np.mean(np.abs(np.array(beside) - extreme)) > BESIDE * logger
    return int(end - start) if cut else 0


def _ask(words: list[str]) -> str:
    return f"; {' or '.join(words)}?" if words else ""

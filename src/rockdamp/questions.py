"""Questions about releases, runs of the solver and counts: likely slips of units and arguments."""

from __future__ import annotations

from typing import Any

import numpy as np

from rockdamp.arrays import Array
from rockdamp.plausibility import LARGEST_YIELD, of_motion
from rockdamp.vocabulary import STANDARD_GRAVITY

COARSEST = 0.2  # step over the stability limit: from there on the corners of the curve feed energy in
FEWEST_IN_BAND = 8  # steps: h <= c/4, docs/theory.md, section 9
LARGE_RELEASE = 0.6  # u0/u_ins, above which few releases are, and e below which few walls are
WIDEST_FRAGILITY = 2.0  # dispersion; of walls under records some 0.2 to 0.8
LONGEST_SAMPLING = 0.25  # between samples of a record, in tau: 0.02 s at a p of 12 rad/s, far above that of walls


def of_start(release_amplitude: Any, yield_displacement_ratio: Any) -> list[str]:
    """Return a warning where no wall of a batch rocks after its release, as all stay on their first branches."""
    x0, a1 = np.broadcast_arrays(np.abs(np.asarray(release_amplitude)), np.asarray(yield_displacement_ratio))
    if not x0.size or (x0 > a1).any() or (a1 > LARGEST_YIELD).any():  # of such a curve it was asked
        return []
    if not x0.any():
        return ["nothing moves the wall: its release_amplitude is 0, and no motion loads it"]
    most = int(np.argmax(x0))
    stated = f"release_amplitude is {x0.flat[most]:g} of u_ins, and a1 is {a1.flat[most]:g}"
    return [f"{stated}: the wall stays on its first branch and does not rock; was it in metres? it is u/u_ins"]


def of_band(width: float, steps: float) -> list[str]:
    """Return a warning where the solver passes a band of fixed time, of the width t_c [rad], in fewer than 8 steps."""
    if steps >= FEWEST_IN_BAND:
        return []
    return [f"width (t_c) is {width:g}: the band has {steps:.2g} steps of the solver; it should have {FEWEST_IN_BAND}"]


def of_exchanged(restitution: Any, release_amplitude: Any) -> list[str]:
    """Return a question where e and the amplitude of the release have each other's usual values."""
    e, x0 = np.max(restitution, initial=0.0), np.min(release_amplitude, initial=1.0)
    if e > LARGE_RELEASE or x0 <= LARGE_RELEASE:
        return []
    return [f"restitution (e) is {e:g} and release_amplitude {x0:g} of u_ins; were the two swapped?"]


def of_counts(collapses: Array, runs: Array) -> list[str]:
    """Return a question where collapses are no counts of runs, or become fewer with the intensity, the last axis."""
    part = (collapses != np.floor(collapses)) & (runs == np.floor(runs)) & (runs > 1)
    if part.any():
        k, n = collapses[part][0], runs[part][0]
        slip = f"; was it a share ({k * n:.3g} of them)?" if np.max(collapses) <= 1 else "; were two arguments swapped?"
        return [f"collapses is {k:g} of {n:g} runs, which is no whole number{slip}"]
    first, last = (np.sum(collapses[..., at] / np.maximum(runs[..., at], 1e-300)) for at in (0, -1))
    return ["collapses become fewer with the intensity; were survivals counted?"] if first > last else []


def of_dispersion(dispersion: Any) -> list[str]:
    """Return a question where a fragility is so wide that collapses hardly depend on the intensity."""
    widest = np.max(np.nan_to_num(dispersion), initial=0.0)
    if widest <= WIDEST_FRAGILITY:
        return []
    stated = f"the dispersion is {widest:.3g}, more than {WIDEST_FRAGILITY:g}"
    return [f"{stated}: collapses hardly depend on the intensity; are intensity and collapses right?"]


def of_run(
    step: Any, limit: Any, steps: int, substeps: int, factors: Array, ground: Array, shape: tuple[int, ...]
) -> list[str]:
    """Return the questions about a run of `solve`: its step in tau, its length and its motions (motions, samples)."""
    h, doubts = np.asarray(step), []
    if (h > COARSEST * np.asarray(limit)).any():
        most = "2 sqrt(a1/b1), the stability limit; it should be a twentieth of it"
        doubts.append(f"step is {np.max(h):g} in tau, more than a fifth of {most}")
    if not ground.size:
        return doubts
    sampling, samples = h * substeps, ground.shape[-1]
    right = "with Wall.load_factor it is frequency_parameter * dt / substeps, for each wall its own"
    walls = bool((factors < 0).all()) and not _is_typed(factors)  # as `Wall.load_factor` is, and no load over K0 u_ins
    if walls and _is_typed(sampling):
        doubts.append(f"step times substeps is {np.max(sampling):g}, a round number as of seconds; {right}")
    elif substeps > 1 and np.max(sampling, initial=0.0) > LONGEST_SAMPLING:
        doubts.append(f"step times substeps, between two samples, is {np.max(sampling):.3g} in tau; {right}")
    if substeps > 1 and steps in (samples - 1, samples):
        doubts.append(f"steps is {steps} and ends the run early; for the whole record it is {substeps * (samples - 1)}")
    if walls:
        doubts += of_motion(float(np.abs(ground).max()))
    if not factors.any():
        doubts.append("load_factor is 0, so that ground_acceleration has no effect; it is Wall.load_factor")
    if len(ground) > 1 and factors.ndim == 1 and shape == factors.shape:
        doubts.append(f"the {len(ground)} motions load each wall together; for records of their own, solve each alone")
    return doubts


def of_rest(peak: Any, factors: Array, ground: Array, curve: Any) -> list[str]:
    """Return a warning where motions rock no wall of a batch; it asks for g where that would."""
    a1 = curve.yield_displacement_ratio
    if not ground.any() or not factors.any() or not np.size(peak) or not (peak < a1).all():
        return []
    load = np.abs(factors).reshape(len(ground), -1).max(axis=1) @ np.abs(ground).max(axis=1)
    part = float(load / np.min(curve.strength_ratio))
    slip = "was ground_acceleration in g? it is" if part < 1 <= part * STANDARD_GRAVITY else "ground_acceleration is"
    return [
        f"no wall rocks: each stays below its u1, as the load is at most {part:.2g} of the strength; {slip} in m s-2"
    ]


def _is_typed(values: Any) -> bool:
    """Return True for numbers of at most two digits, which nothing computed has."""
    return all(np.isclose(value, float(f"{value:.2g}"), rtol=1e-9, atol=0) for value in np.ravel(values)[:3])

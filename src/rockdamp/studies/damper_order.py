"""Compare ECD of order m with CR by its order, in the free decay of the reference curve: from viscous to impact.

The damping ratio of ECD is exact, nothing is fitted. Beside it stands CR itself after a small change of e: a damper
that is nearer to CR than that is as good as CR.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.histories.half_cycles import turns
from rockdamp.mechanics.damping import Damping
from rockdamp.solvers.newmark import solve
from rockdamp.solvers.response import Reference
from rockdamp.statistics.against_restitution import CHANGES_OF_E
from rockdamp.studies.decays import step_count

MEASURES = ("rms_error", "peak_error", "duration_error")


def damper_order(config: Config) -> xr.Dataset:
    """Compare ECD of each order with CR: errors at each e, and histories at the e of Fig. 3."""
    return xr.merge([_errors(config), _shown(config)], join="exact")


def _release(config: Config) -> dict[str, Any]:
    """Return the arguments of the solver for a decay over the response length."""
    return {
        "release_amplitude": config.release_amplitude,
        "step": config.solver.step,
        "steps": step_count(config.matching.response_length, config.solver.step),
        "store_every": 1,
        "scheme": config.solver.scheme,
    }


def _errors(config: Config) -> xr.Dataset:
    """Return the errors of each order and of CR with another e, with the damping ratios.

    ``rms_error`` is sqrt(Err/k) of Eq. (17). ``peak_error`` and ``duration_error`` are the largest difference of a
    peak, and of the time from one peak to the next, as a fraction of those under CR.
    """
    e, order, change = (getattr(config.damper_order, name) for name in ("restitution", "order", "restitution_change"))
    release = _release(config)
    step, steps = release["step"], release["steps"]
    impact = solve(config.curve, Damping.cr(e), **release)
    reference = Reference(impact.displacement, np.arange(e.size), [steps])
    peaks, elapsed = turns(impact.displacement, impact.velocity, step)

    def errors(damping: Damping) -> list[Array]:
        run = solve(config.curve, damping, reference=reference, **release)
        found, at = turns(run.displacement, run.velocity, step)
        most = min(found.shape[1], peaks.shape[1])
        lasting, lasted = (np.diff(times[:, :most], prepend=0.0) for times in (at, elapsed))
        relative = (found[:, :most] / peaks[:, :most] - 1, lasting / lasted - 1)
        largest = [np.fmax.reduce(np.abs(difference), axis=-1, initial=np.nan) for difference in relative]
        return [np.sqrt(run.error[0] / steps), *largest]

    exact = [Damping.of_restitution(e, order=m) for m in order]
    of_order = np.stack([errors(damping) for damping in exact], axis=1)
    varied = np.stack([errors(Damping.cr(e + side * change)) for side in (-1, 1)], axis=1)
    return xr.Dataset(
        {
            **{name: (("order", "restitution"), of_order[row]) for row, name in enumerate(MEASURES)},
            **{f"varied_{name}": (("variation", "restitution"), varied[row]) for row, name in enumerate(MEASURES)},
            "damping_ratio": (("order", "restitution"), np.stack([damping.damping_ratio for damping in exact])),
        },
        coords={
            "order": order,
            "variation": list(CHANGES_OF_E),
            "restitution": e,
            "restitution_change": change,
            "release_amplitude": config.release_amplitude,
            "response_length": config.matching.response_length,
        },
    )


def _shown(config: Config) -> xr.Dataset:
    """Return histories under CR and each order at the e of Fig. 3."""
    e, order, release = config.damping_force.restitution, config.damper_order.order, _release(config)
    dampings = [Damping.cr(e), *(Damping.of_restitution(e, order=m) for m in order)]
    impact, *runs = [solve(config.curve, damping, **release) for damping in dampings]
    force = [
        damping.coefficient(config.curve, run.displacement, run.velocity) * run.velocity
        for damping, run in zip(dampings[1:], runs, strict=True)
    ]
    return xr.Dataset(
        {
            "shown_reference_displacement": ("tau", impact.displacement),
            "shown_reference_velocity": ("tau", impact.velocity),
            "shown_displacement": (("order", "tau"), np.stack([run.displacement for run in runs])),
            "shown_velocity": (("order", "tau"), np.stack([run.velocity for run in runs])),
            "shown_damping_force": (("order", "tau"), np.stack(force)),
        },
        coords={
            "order": order,
            "tau": release["step"] * np.arange(release["steps"] + 1),
            "shown_restitution": e,
        },
    )

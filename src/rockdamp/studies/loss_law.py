"""The cost of a constant e where the relative loss of an impact is larger at small amplitudes.

The law has e at one amplitude and an exponent g (docs/theory.md, section 8). It is compared with
the constant e under earthquakes.
"""

from __future__ import annotations

import xarray as xr

from rockdamp.config import Config, LossLaw
from rockdamp.constants import REFERENCE
from rockdamp.mechanics.damping import Damping
from rockdamp.studies.runner import Case, run_and_compare, unstack, use


def list_cases(section: LossLaw) -> list[Case]:
    """Return the constant e, and the law with each pair of exponent and amplitude.

    Parameters
    ----------
    section : LossLaw
        The study's part of the config.
    """
    e = section.restitution
    constant = Case("constant e", use(Damping(REFERENCE, e)), section.step)
    cases = [constant]
    for g in section.exponent:
        for amplitude in section.amplitude:
            law = Damping(REFERENCE, e, loss_exponent=g, reference_amplitude=amplitude)
            cases.append(
                Case(
                    f"g = {g:g}, e at {amplitude:g}",
                    use(law),
                    section.step,
                    reference=constant.name,
                    coordinates={"loss_exponent": g, "reference_amplitude": amplitude},
                )
            )
    return cases


def loss_law(config: Config) -> xr.Dataset:
    """Compare each law with the constant e, over all walls and wall by wall."""
    section = config.loss_law
    cases = list_cases(section)
    compared = run_and_compare(cases, config)
    grid = unstack(compared, cases, "loss_exponent", "reference_amplitude")
    grid = grid.transpose("wall", "loss_exponent", "reference_amplitude", ...)
    return grid.assign_coords(restitution=section.restitution)

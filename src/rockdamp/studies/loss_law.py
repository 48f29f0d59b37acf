"""What a constant e costs, if the loss of an impact falls with the amplitude: the law beside it, under earthquakes.

The law has e at one amplitude and an exponent g (docs/theory.md, section 8).
"""

from __future__ import annotations

import xarray as xr

from rockdamp.config import Config, LossLaw
from rockdamp.mechanics.damping import Damping
from rockdamp.studies.runner import Case, run_and_compare, unstack, use


def cases(section: LossLaw) -> list[Case]:
    """Return the constant e, and the law with each pair of exponent and amplitude beside it."""
    e, step, constant = section.restitution, section.step, "constant e"
    laws = {
        f"g = {g:g}, e at {at:g}": Damping("CR", e, loss_exponent=g, reference_amplitude=at)
        for g in section.exponent
        for at in section.amplitude
    }
    return [
        Case(constant, use(Damping("CR", e)), step),
        *(Case(name, use(law), step, constant) for name, law in laws.items()),
    ]


def loss_law(config: Config) -> xr.Dataset:
    """Compare each law with the constant e, over all walls together and wall by wall, with intervals over stations."""
    section = config.loss_law
    return (
        unstack(
            run_and_compare(cases(section), config),
            loss_exponent=section.exponent,
            reference_amplitude=section.amplitude,
        )
        .transpose("wall", "loss_exponent", "reference_amplitude", ...)
        .assign_coords(restitution=section.restitution)
    )

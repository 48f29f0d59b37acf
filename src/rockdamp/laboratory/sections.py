"""The config's sections of measured tests, and the whole config, which has them beside those of the core."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

from pydantic import Field

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.config.earthquakes import Bootstrap
from rockdamp.config.kinds import (
    INTEGRAL,
    OrNull,
    Section,
    Seed,
    Text,
    Whole,
    ascending,
)


class SimulatedTrials(Section):
    draws: Whole = Field(ge=1, le=100_000, description="Number of sets of each model.")
    seed: Seed = Field(description="Seed of the sets.")


_Impacts = Annotated[int, Field(ge=3, le=100), INTEGRAL]
_NearlyRigid = Annotated[float, Field(ge=0.002, le=0.05)]
_Release = Annotated[float, Field(ge=0.1, le=0.9)]


class MeasuredRocking(Section):
    trials: Text = Field(description="Measured trials, seen from the folder of the run.")
    impacts_used: Annotated[Array, ascending(_Impacts)] = Field(
        description="Numbers of impacts of each trial that are used, the first ones, ascending."
    )
    shown_impacts: _Impacts = Field(
        description="That of these numbers with which all but the comparison of models is done."
    )
    yield_displacement_ratio: Annotated[Array, ascending(_NearlyRigid)] = Field(
        description="a1 of nearly rigid curves, ascending; their plateau is at 1 - 2 a1. [-]"
    )
    release_amplitude: Annotated[Array, ascending(_Release)] = Field(
        description="Displacements from which the blocks may have been released, u0/u_ins, ascending. [-]"
    )
    shown_yield_displacement_ratio: _NearlyRigid = Field(
        description="a1 of the curve on which the models are compared. [-]"
    )
    shown_release_amplitude: _Release = Field(description="The release from which the models are compared. [-]")
    amplitude_exponent: Annotated[Array, ascending(Annotated[float, Field(ge=-2, le=2)], 3)] = Field(
        description="Exponents of the energy left with which the loss per impact may go, ascending. [-]"
    )
    held_out: Whole = Field(ge=1, le=6, description="Number of geometries that are held out, in every choice.")
    bootstrap: Bootstrap = Field(description="Trials are drawn again within their geometries.")
    simulated: SimulatedTrials = Field(
        description="Sets of trials that each model makes with the fitted errors, among which the maker is looked for."
    )


class LaboratoryConfig(Config):
    """The paper's study, as config/default.yaml states it; null leaves a study out, and with it all that reads it."""

    measured_rocking: Annotated[MeasuredRocking, OrNull] = Field(
        description="Which damping model the ratios of velocity of measured free rocking support."
    )


def broken(config: LaboratoryConfig) -> Iterator[tuple[str, str]]:
    """Yield what breaks a rule between keys of measured tests: the key, and what is wrong."""
    if measured := config.measured_rocking:
        shown, used = measured.shown_impacts, measured.impacts_used.tolist()
        if shown not in used:
            yield "measured_rocking.shown_impacts", f"is {shown}; it must be among impacts_used, {used}"
        if not Path(measured.trials).is_file():
            text = f"is {measured.trials!r}; it must be a file, seen from the folder of the run"
            yield "measured_rocking.trials", text


if __name__ == "__main__":
    print(json.dumps(LaboratoryConfig.model_json_schema(), indent=2))

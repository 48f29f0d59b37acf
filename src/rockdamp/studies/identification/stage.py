"""The study of identification: simulated records identified, and the models that a ladder's records support."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import xarray as xr

from rockdamp.config import Config
from rockdamp.motions.records import Record
from rockdamp.progress import track, without_bars
from rockdamp.studies.identification.ladder import supported
from rockdamp.studies.identification.settings import IdentificationSettings
from rockdamp.studies.identification.simulated import Maker, gathered


def identification(config: Config, ladder: Mapping[str, Record]) -> xr.Dataset:
    """Identify records made with parameters drawn from the prior, and compare models for the records of a ladder.

    Parameters
    ----------
    config : dict
        Has the keys of `IdentificationSettings`.
    ladder : dict of str to Record
        Synthetic records, by their names.

    Returns
    -------
    xarray.Dataset
        Of what `simulated.gathered` and `ladder.supported` return.
    """
    given = IdentificationSettings.of(config)
    maker = maker_of(given)
    records = []
    for number in track(range(given.simulated.draws), "simulated records"):
        with without_bars():
            records.append(maker.judged(number))
    return gathered(maker.names, records).merge(supported(given, ladder))


def maker_of(given: IdentificationSettings) -> Maker:
    """Return what makes the records, with the prior that has the sensor's noise as it is simulated."""
    simulated = given.simulated
    prior = replace(
        given.prior, sensor_deviation=simulated.sensor_deviation, sensor_correlation=simulated.sensor_correlation
    )
    return Maker(given.wall, given.ultimate_ratio, given.softening, given.step, prior, simulated)

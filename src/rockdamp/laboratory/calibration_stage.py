"""The study of calibration: the wall of Fig. 8 from its record."""

from __future__ import annotations

import xarray as xr

from rockdamp.config import Config
from rockdamp.laboratory.calibration import calibrate
from rockdamp.motions.records import Record


def study(config: Config, record: Record) -> xr.Dataset:
    """Calibrate the wall of the config's ``validation`` section: its a3 and softening are kept, a1, b1 and e fitted."""
    return calibrate(
        record,
        config.validation.wall,
        ultimate_displacement_ratio=config.validation.curve.ultimate_displacement_ratio,
        softening=config.validation.curve.softening,
        step=config.validation.step,
    )

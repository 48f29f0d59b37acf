"""The walls of a study of free decay."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from rockdamp.arrays import Array
from rockdamp.config import Config
from rockdamp.constants import STUDIES
from rockdamp.mechanics.curve import TrilinearCurve


@dataclass(frozen=True)
class Study:
    """The walls of one study, along which one parameter varies.

    Parameters
    ----------
    name : str
        Name of the study.
    parameter : str
        Name of the parameter that varies, a dimension of the study's datasets.
    values : ndarray, shape (walls,)
        Values of the parameter.
    curve : TrilinearCurve, shape (walls,)
        Curves of the walls.
    release_amplitude : ndarray, shape (walls,)
        Displacement of the release, u0/u_ins. [-]
    frequency_parameter : ndarray, shape (walls,)
        Frequency parameter p. [rad s-1]
    varies_wall : bool
        Whether the parameter belongs to the wall, and changes p, or to the curve or the release.
    """

    name: str
    parameter: str
    values: Array
    curve: TrilinearCurve
    release_amplitude: Array
    frequency_parameter: Array
    varies_wall: bool


def make_study(name: str, config: Config) -> Study:
    """Return the walls of the study `name`, a key of `rockdamp.constants.STUDIES`."""
    parameter = STUDIES[name]
    values = np.array(getattr(config.studies, name))
    release_amplitude = np.full(values.shape, config.release_amplitude)
    wall = config.wall.make()
    curve = config.curve.make()
    varies_wall = parameter in type(config.wall).model_fields
    if varies_wall:
        wall = config.wall.make(**{parameter: values})
    elif parameter == "release_amplitude":
        release_amplitude = values
    else:
        curve = config.cracked_curves()
    return Study(
        name=name,
        parameter=parameter,
        values=values,
        curve=curve.map(lambda ratio: np.broadcast_to(ratio, values.shape)),
        release_amplitude=release_amplitude,
        frequency_parameter=np.broadcast_to(wall.frequency_parameter, values.shape),
        varies_wall=varies_wall,
    )

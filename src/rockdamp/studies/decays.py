"""Free decays under a coefficient of restitution: the references of every study."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.mechanics.wall import Wall
from rockdamp.solvers.newmark import solve
from rockdamp.vocabulary import STUDIES

Config = dict[str, Any]


@dataclass(frozen=True)
class Study:
    """The walls of one study; every array has the length of `values`.

    Attributes
    ----------
    name, parameter : str
        One of `STUDIES` and its dimension.
    values : ndarray
        Of the parameter.
    curve : TrilinearCurve
    release_amplitude : ndarray
        u0/u_ins. [-]
    frequency_parameter : ndarray
        p. [rad s-1]
    """

    name: str
    parameter: str
    values: Array
    curve: TrilinearCurve
    release_amplitude: Array
    frequency_parameter: Array


def make_wall(section: Config) -> Wall:
    """Build the wall of a config section that states slenderness (h/t) in place of the height."""
    options = dict(section)
    thickness = np.asarray(options.pop("thickness"), dtype=float)
    return Wall(thickness=thickness, height=thickness * np.asarray(options.pop("slenderness"), dtype=float), **options)


def describe(name: str, config: Config) -> Study:
    """Return the walls of study `name` as `config` states them."""
    parameter = STUDIES[name]
    values = np.asarray(config["studies"][name][parameter], dtype=float)
    wall, curve = dict(config["wall"]), dict(config["curve"])
    release = np.full(values.shape, float(config["release_amplitude"]))
    if name == "amplitude":
        release = values
    elif name == "cracked_stiffness":
        beyond = config["studies"][name]["plateau_ratio_beyond"]
        wide = values >= beyond["cracked_stiffness_ratio"]
        curve["plateau_ratio"] = np.where(wide, beyond["plateau_ratio"], curve["plateau_ratio"])
        curve["cracked_stiffness_ratio"] = values
    else:
        wall[parameter] = values
    softening = curve.pop("softening")
    arrays = {key: np.broadcast_to(np.asarray(value, dtype=float), values.shape) for key, value in curve.items()}
    frequency = np.broadcast_to(make_wall(wall).frequency_parameter, values.shape)
    return Study(name, parameter, values, TrilinearCurve(softening=softening, **arrays), release, frequency)


def restitution_grid(config: Config) -> Array:
    """Return the coefficients of restitution that the config states, rounded to 12 decimals."""
    grid = config["restitution"]
    count = round((grid["stop"] - grid["start"]) / grid["step"]) + 1
    return np.round(grid["start"] + grid["step"] * np.arange(count), 12)


def step_count(length: float, step: float) -> int:
    """Steps that a response of `length` in tau takes."""
    return int(round(length / step))


def study(name: str, config: Config) -> xr.Dataset:
    """Run the free decays of one study, to the longest window.

    Parameters
    ----------
    name : {"amplitude", "slenderness", "overburden", "cracked_stiffness"}
    config : dict
        Validated; uses ``solver``, ``wall``, ``curve``, ``release_amplitude``, ``restitution``, ``studies`` and
        ``windows``.

    Returns
    -------
    xarray.Dataset
        ``displacement`` and ``velocity`` (study parameter, restitution, tau) and ``impacts``.
    """
    walls = describe(name, config)
    restitution = restitution_grid(config)
    step = float(config["solver"]["step"])
    steps = step_count(float(config["windows"]["stop"]), step)
    response = solve(
        walls.curve.map(lambda parameter: parameter[:, None]),
        Damping.cr(restitution),
        release_amplitude=walls.release_amplitude[:, None],
        step=step,
        steps=steps,
        store_every=1,
        scheme=config["solver"]["scheme"],
    )
    dims = (walls.parameter, "restitution")
    coords: dict[str, Any] = {
        walls.parameter: walls.values,
        "restitution": restitution,
        "tau": step * np.arange(steps + 1),
        "frequency_parameter": (walls.parameter, walls.frequency_parameter),
    }
    if name == "cracked_stiffness":
        coords["plateau_ratio"] = (walls.parameter, np.asarray(walls.curve.plateau_ratio))
    return xr.Dataset(
        {
            "displacement": ((*dims, "tau"), response.displacement),
            "velocity": ((*dims, "tau"), response.velocity),
            "impacts": (dims, response.impacts),
        },
        coords=coords,
    )

"""Arguments are converted once or refused by their names; the copies that objects keep cannot be changed later."""

import re

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import rockdamp as rd
from rockdamp import arguments


class Unit(float):
    """A number of another package that carries its unit, as astropy's."""

    unit = "mm"


class Metres:
    """An array of another package that carries its unit, as pint's, which xarray takes as it is."""

    magnitude, dtype, shape, ndim = 0.3, np.dtype(float), (), 0

    def __array_function__(self, *_):
        return NotImplemented

    __array_ufunc__ = None


NO_NUMBERS = [
    [0.3, 1j],
    np.array(["0.3"]),
    np.ma.masked_array([0.3, 0.4], mask=[True, False]),
    Unit(0.3),
    xr.DataArray(Metres()),
]


@pytest.mark.parametrize("value", NO_NUMBERS, ids=lambda value: type(value).__name__)
def test_what_is_no_real_number_is_refused_by_the_arguments_name(value):
    with pytest.raises(rd.InputError, match="thickness is .*; it must be a number, or an array of them"):
        rd.Wall(value, 4.5)


@pytest.mark.parametrize("value", [1, np.float32(1), np.int8(1), [1, 1.0], (1,), range(1, 2), pd.Series([1.0])])
def test_real_numbers_of_any_kind_are_taken(value):
    array = arguments.numbers("x", value)
    assert array.dtype == np.float64 and (array == np.asarray(value, dtype=float)).all()
    assert not array.flags.writeable


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("band", "Damping has no 'band'; Damping.of_restitution(e, 'BAND') or Damping('BAND', damping_ratio, width)"),
        ("cdr", "Damping has no 'cdr'; Damping('CDR', damping_ratio) makes one"),
        ("formulas", "type object 'Damping' has no attribute 'formulas'"),
    ],
)
def test_a_model_asked_for_as_an_attribute_says_how_it_is_made(name, said):
    with pytest.raises(AttributeError, match=re.escape(said)):
        getattr(rd.Damping, name)


def test_names_are_taken_in_capitals_and_small_letters():
    assert rd.Damping("cdr", 0.05) == rd.Damping("CDR", 0.05) != rd.Damping("SDR", 0.05)
    assert rd.Damping.of_restitution(0.8, "band").model == "BAND"
    assert rd.TrilinearCurve.preset("Moderate") == rd.TrilinearCurve.preset("moderate")
    assert rd.TrilinearCurve(0.04, 0.85, 0.95, "Translated").softening == "translated"


def test_what_is_kept_is_a_copy_that_cannot_be_written():
    heights, accelerations = np.array([3.0, 4.5]), np.array([0.0, 1.0, 0.0])
    wall, curve = rd.Wall(0.3, heights), rd.TrilinearCurve(0.01 * heights, 0.85)
    record = rd.Record([0.0, 0.1, 0.2], accelerations)
    heights[0], accelerations[1] = np.nan, np.nan
    assert wall.height[0] == 3.0 and curve.yield_displacement_ratio[0] == 0.03 and record.ground_acceleration[1] == 1.0
    for kept in (wall.height, curve.yield_displacement_ratio, record.ground_acceleration):
        with pytest.raises(ValueError, match="read-only"):
            kept[...] = np.nan
    named = xr.DataArray([3.0, 4.5], dims="height")
    wall = rd.Wall(0.3, named)
    named[0] = np.nan
    assert wall.height[0] == 3.0


def test_objects_are_equal_by_value_and_say_why_they_have_no_hash():
    many, other = rd.Wall(0.3, [3.0, 4.5]), rd.Wall(0.3, [3.0, 4.6])
    assert (many == rd.Wall(0.3, [3.0, 4.5])) is True and (many == other) is False and (many == 3) is False
    assert rd.Wall(0.3, [3.0, 4.5]) != rd.Wall(0.3, [3.0])
    assert hash(rd.Wall(0.3, 4.5)) == hash(rd.Wall(0.3, 4.5)) and rd.Wall(0.3, 3.0) != rd.Parapet(0.3, 3.0)
    assert hash(rd.TrilinearCurve.preset("new")) == hash(rd.TrilinearCurve.preset("NEW"))
    for kind, held in (("Wall", many), ("Record", rd.Record([0, 1], [0, 1]))):
        with pytest.raises(TypeError, match=f"a {kind} that holds arrays has no hash"):
            hash(held)
    run = {"release_amplitude": 0.9, "step": 0.01, "steps": 300, "store_every": 1}
    one, two = (rd.solve(rd.TrilinearCurve(0.04, 0.85), rd.Damping.cr(0.8), **run) for _ in range(2))
    assert (one == two) is True
    one, two, other = (rd.Wall(0.3, xr.DataArray([3.0, height], dims="h")) for height in (4.5, 4.5, 4.6))
    assert one == two != other and one != many


def test_shapes_that_do_not_broadcast_or_are_too_large_are_refused():
    with pytest.raises(rd.InputError, match=r"shapes do not broadcast .*thickness \(2,\), height \(3,\)"):
        rd.Wall([0.3, 0.4], [3.0, 3.5, 4.0])
    with pytest.raises(rd.InputError, match=r"shapes do not broadcast .*curve \(2,\), damping \(3,\)"):
        rd.solve(rd.TrilinearCurve([0.04, 0.05], 0.85), rd.Damping.cr([0.7, 0.8, 0.9]), step=0.01, steps=1)
    many = np.linspace(0.02, 0.1, 20_000)
    with pytest.raises(rd.InputError, match="there must be at most 268,435,456 elements"):
        rd.TrilinearCurve(many[:, None], 0.8 + many)


def test_a_history_has_the_same_cap_in_python_as_on_the_command_line():
    with pytest.raises(rd.InputError, match=r"at most 1e\+07|at most 10,000,001"):
        rd.free_decay(rd.TrilinearCurve(0.04, 0.85), rd.Damping.cr(0.8), length=1e7)


def test_a_masked_array_that_misses_nothing_is_an_array_and_names_need_coordinates():
    assert rd.Wall(np.ma.array([0.3, 0.4]), 4.0) == rd.Wall([0.3, 0.4], 4.0)
    with pytest.raises(rd.InputError, match="thickness is an array with masked values"):
        rd.Wall(np.ma.array([0.3, 0.4], mask=[True, False]), 4.0)
    with pytest.raises(rd.InputError, match=r"is a Variable of xarray; it must be .* or an xarray.DataArray"):
        rd.Wall(xr.Variable("wall", [0.3, 0.4]), 4.0)
    with pytest.raises(rd.InputError, match=r"damping_ratio of the building has shape \(2,\); it must be one number"):
        rd.Building(period=0.25, storeys=3, storey=3, damping_ratio=np.array([0.1, 0.2]))
    assert rd.Wall([], 4.0).thickness.shape == (0,)  # of a table without rows

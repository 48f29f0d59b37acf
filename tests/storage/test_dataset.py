"""The glossary, and the files that are written from it."""

import json

import numpy as np
import pytest
import xarray as xr
from minimal_build import KINDS
from repository import ROOT

from rockdamp.errors import InputError
from rockdamp.storage import dataset


@pytest.fixture
def orders():
    dims = ("scheme", "excitation", "damping_model")
    coords = {
        "scheme": ["newmark"],
        "excitation": ["free", "forced"],
        "damping_model": ["CR", "ECD"],
    }
    orders = {
        name: (dims, np.full((1, 2, 2), 2.0))
        for name in ("convergence_order", "finest_convergence_order")
    }
    errors = {"solver_error": ((*dims, "step"), np.arange(8.0).reshape(1, 2, 2, 2))}
    return xr.Dataset(errors | orders, coords | {"step": [1, 2.0]})


def write(data, path):
    dataset.write(data, path, "convergence", config={"seed": 1}, code_version="0+0")


def test_an_interval_without_an_entry_is_described_by_its_variable():
    variables = dataset.variables("comparison")
    assert variables["log_error_interval"] == {
        "units": "1",
        "long_name": "95 % bootstrap interval of log_error",
    }


def test_a_name_has_one_unit_in_every_dataset():
    units = {name: entry["units"] for name, entry in dataset.glossary()["names"].items()}
    for kind in dataset.glossary()["datasets"]:
        variables = dataset.variables(kind)
        assert [
            name
            for name, entry in variables.items()
            if entry["units"] != units.get(name, entry["units"])
        ] == []


def test_a_dataset_comes_back_with_units_names_and_its_origin_and_two_writes_are_the_same_bytes(
    orders, tmp_path
):
    for name in ("a.nc", "b.nc"):
        write(orders, tmp_path / name)
    assert (tmp_path / "a.nc").read_bytes() == (tmp_path / "b.nc").read_bytes()
    with xr.open_dataset(tmp_path / "a.nc") as back:
        xr.testing.assert_equal(back.load(), orders)
    for name, variable in back.variables.items():
        assert variable.attrs["units"] and variable.attrs["long_name"], name
        assert "_FillValue" not in variable.attrs
        assert (
            name in back.data_vars
            or "_FillValue" not in variable.encoding
            or variable.dtype.kind in "US"
        )
    assert {"title", "source", "references", "Conventions", "config", "code_version"} <= set(
        back.attrs
    )
    assert json.loads(back.attrs["config"]) == {"seed": 1}


def test_what_the_glossary_does_not_know_is_not_written(orders, tmp_path):
    with pytest.raises(InputError, match="surprise"):
        write(orders.assign(surprise=1.0), tmp_path / "convergence.nc")
    with pytest.raises(InputError, match="missing.*convergence_order"):
        write(orders.drop_vars("convergence_order"), tmp_path / "convergence.nc")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("grid", "stored"),
    [
        (0.1 * np.arange(1, 8), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]),
        (np.array([0.1 + 0.2, 5.999999999999999, 0.82]), [0.3, 6.0, 0.82]),
        (np.arange(4) / 3, [0.0, 0.333333333333, 0.666666666667, 1.0]),
        (np.geomspace(0.1, 0.4, 5), np.geomspace(0.1, 0.4, 5)),
        (np.arange(5), np.arange(5)),
    ],
)
def test_sel_finds_the_values_that_are_printed_and_geometric_grids_keep_their_bits(
    grid, stored, orders, tmp_path
):
    write(orders.isel(step=[0] * len(grid)).assign_coords(step=grid), tmp_path / "convergence.nc")
    back = dataset.read(tmp_path / "convergence.nc")
    np.testing.assert_array_equal(back["step"], stored)
    assert back.sel(step=stored[2]).sizes == orders.isel(step=0).sizes


@pytest.mark.parametrize("name", ["solver_error", "convergence_order", "step"])
def test_a_flipped_bit_is_an_error_not_another_value(name, orders, tmp_path):
    path = tmp_path / "convergence.nc"
    write(orders, path)
    damaged = bytearray(path.read_bytes())
    damaged[damaged.index(orders[name].values.tobytes()) + 7] ^= 1
    path.write_bytes(damaged)
    with pytest.raises((OSError, RuntimeError)):
        dataset.read(path)


def test_built_datasets_are_what_the_glossary_says():
    """Whatever stands among the results now is read back against the glossary."""
    found = 0
    for name, kind in KINDS.items():
        for path in (ROOT / "results").glob(f"{name}.nc"):
            dataset.check(dataset.read(path), kind)
            found += 1
    if not found:
        pytest.skip("nothing is built in results/")


def test_large_variables_are_compressed_but_the_long_histories_of_the_decays(orders, tmp_path):
    """Those are for later stages alone, and keep two thirds of their size. A checksum has each."""
    many = np.linspace(0.0, 1.0, dataset.LARGE + 1)
    dims = ("slenderness", "restitution")
    history = (*dims, "tau"), np.sin(many)[None, None]
    of_wall = {"frequency_parameter": ("slenderness", [4.0]), "impacts": (dims, [[7]])}
    decay = {"displacement": history, "velocity": history, **of_wall}
    coords = {"slenderness": [12.0], "restitution": [0.9], "tau": many}
    decays = xr.Dataset(decay, coords).set_coords("frequency_parameter")
    dataset.write(decays, tmp_path / "decay.nc", "decay", config={}, code_version="0+0")
    write(orders.isel(step=[0]).sel(step=np.ones(many.size)), tmp_path / "convergence.nc")
    for name, compressed in (("displacement", False), ("solver_error", True)):
        stored = dataset.read(tmp_path / ("convergence.nc" if compressed else "decay.nc"))[
            name
        ].encoding
        assert [stored[kind] for kind in ("zlib", "shuffle", "fletcher32")] == [
            compressed,
            compressed,
            True,
        ]

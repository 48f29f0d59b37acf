"""The glossary, and the files that are written from it.

The tests that read the minimal build say so by the fixture `minimal`, which builds it where it is
missing.
"""

import json

import numpy as np
import pytest
import xarray as xr
from minimal_build import DATASETS, KINDS, PARTS

from rockdamp.errors import InputError
from rockdamp.storage import dataset

INDEX = ("scheme", "excitation", "damping_model")


@pytest.fixture
def orders():
    """A dataset of the kind convergence."""
    coords = {
        "scheme": ["newmark"],
        "excitation": ["free", "forced"],
        "damping_model": ["CR", "ECD"],
        "step": [1, 2.0],
    }
    variables = {
        "convergence_order": (INDEX, np.full((1, 2, 2), 2.0)),
        "finest_convergence_order": (INDEX, np.full((1, 2, 2), 2.0)),
        "solver_error": ((*INDEX, "step"), np.arange(8.0).reshape(1, 2, 2, 2)),
    }
    return xr.Dataset(variables, coords)


@pytest.fixture
def write(tmp_path):
    """Write a dataset to a new file; return the path."""

    def write(data, kind="convergence", name="data.nc"):
        path = tmp_path / name
        dataset.write(data, path, kind, config={"seed": 1}, code_version="0+0")
        return path

    return write


# --- the glossary ---------------------------------------------------------------------------------


def test_interval_without_an_entry_is_described_by_its_variable():
    entry = dataset.variables("comparison")["log_error_interval"]
    assert entry == {"units": "1", "long_name": "95 % bootstrap interval of log_error"}


@pytest.mark.parametrize("kind", dataset.glossary()["datasets"])
def test_name_has_one_unit_in_every_dataset(kind):
    names = dataset.glossary()["names"]
    for name, entry in dataset.variables(kind).items():
        assert entry["units"] == names.get(name, entry)["units"], name


def test_unknown_name_is_refused(orders, write, tmp_path):
    with pytest.raises(InputError, match="surprise"):
        write(orders.assign(surprise=1.0))
    assert list(tmp_path.iterdir()) == []


def test_missing_name_is_refused(orders, write, tmp_path):
    with pytest.raises(InputError, match="missing.*convergence_order"):
        write(orders.drop_vars("convergence_order"))
    assert list(tmp_path.iterdir()) == []


# --- files ----------------------------------------------------------------------------------------


def test_dataset_comes_back_equal(orders, write):
    with xr.open_dataset(write(orders)) as stored:
        xr.testing.assert_equal(stored.load(), orders)


def test_two_writes_are_the_same_bytes(orders, write):
    first = write(orders, name="first.nc").read_bytes()
    assert write(orders, name="second.nc").read_bytes() == first


def test_variables_have_units_and_names(orders, write):
    with xr.open_dataset(write(orders)) as stored:
        for name, variable in stored.variables.items():
            assert variable.attrs["units"], name
            assert variable.attrs["long_name"], name


ANSWERS = [kind for kind, entry in dataset.glossary()["datasets"].items() if "written_by" in entry]


@pytest.mark.parametrize("kind", ANSWERS)
def test_meanings_fit_the_axes_of_plots(kind):
    """Plots of xarray label their axes and legends with the long_name."""
    for name, entry in dataset.variables(kind).items():
        assert len(entry["long_name"]) <= 60, name


@pytest.mark.parametrize("kind", dataset.glossary()["datasets"])
def test_comment_belongs_to_its_meaning(kind):
    meanings = dataset.glossary()["datasets"][kind].get("says", {})
    entries = dataset.variables(kind)
    for name, meaning in meanings.items():
        if "long_name" in meaning:
            assert entries[name].get("comment") == meaning.get("comment"), name


def test_comment_is_written():
    model = xr.Dataset(coords={"damping_model": ["CR"]})
    attributes = dataset.describe(model, "response")["damping_model"].attrs
    assert attributes["long_name"] == "damping model"
    assert attributes["comment"].startswith("CR, CDC, CDR or SDR of the paper")


def test_coordinates_have_no_fill_value(orders, write):
    with xr.open_dataset(write(orders)) as stored:
        assert "_FillValue" not in stored["step"].encoding


def test_file_states_its_origin(orders, write):
    attributes = xr.open_dataset(write(orders)).attrs
    assert attributes["Conventions"] == "CF-1.11"
    assert attributes["title"] == "Error of both schemes against the step, and its order"
    assert json.loads(attributes["config"]) == {"seed": 1}
    assert attributes["code_version"] == "0+0"
    assert {"source", "references"} <= set(attributes)


GRIDS = {
    "tenths": (0.1 * np.arange(1, 8), [0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7]),
    "noise": (np.array([0.1 + 0.2, 5.999999999999999, 0.82]), [0.3, 6.0, 0.82]),
    "thirds": (np.arange(4) / 3, [0.0, 0.333333333333, 0.666666666667, 1.0]),
    "geometric": (np.geomspace(0.1, 0.4, 5), np.geomspace(0.1, 0.4, 5)),
    "integers": (np.arange(5), np.arange(5)),
}


@pytest.mark.parametrize(("grid", "stored"), GRIDS.values(), ids=GRIDS)
def test_sel_finds_printed_values(grid, stored, orders, write):
    path = write(orders.isel(step=[0] * len(grid)).assign_coords(step=grid))
    back = dataset.read(path)
    np.testing.assert_array_equal(back["step"], stored)
    assert back.sel(step=stored[2]).sizes == orders.isel(step=0).sizes


@pytest.mark.parametrize("name", ["solver_error", "convergence_order", "step"])
def test_flipped_bit_is_an_error(name, orders, write):
    path = write(orders)
    content = bytearray(path.read_bytes())
    content[content.index(orders[name].values.tobytes()) + 7] ^= 1
    path.write_bytes(content)
    with pytest.raises((OSError, RuntimeError)):
        dataset.read(path)


def test_large_variables_are_compressed(orders, write):
    count = 10_001
    path = write(orders.isel(step=[0] * count).assign_coords(step=np.arange(count)))
    encoding = dataset.read(path)["solver_error"].encoding
    assert encoding["zlib"] and encoding["shuffle"] and encoding["fletcher32"]


def test_histories_of_decays_are_not_compressed(write):
    tau = np.linspace(0.0, 1.0, 10_001)
    history = (("slenderness", "restitution", "tau"), np.sin(tau)[None, None])
    variables = {
        "displacement": history,
        "velocity": history,
        "impacts": (("slenderness", "restitution"), [[7]]),
    }
    coords = {
        "slenderness": [12.0],
        "restitution": [0.9],
        "tau": tau,
        "frequency_parameter": ("slenderness", [4.0]),
    }
    encoding = dataset.read(write(xr.Dataset(variables, coords), "decay"))["displacement"].encoding
    assert not encoding["zlib"] and not encoding["shuffle"] and encoding["fletcher32"]


# --- missing integers -----------------------------------------------------------------------------


@pytest.fixture
def parts(minimal):
    """The histories that one job ran, and the same with no history of the first wall."""
    return dataset.read(minimal / "earthquakes/records-0.nc")


@pytest.fixture
def rewritten(parts, write):
    """The path of the same histories, of which those of the first wall are not run."""
    parts["collapsed"][{"wall": 0}] = -1
    parts["converged"][{"wall": 0}] = -1
    return write(parts, "earthquake_records")


def test_missing_integers_are_nan_in_plain_xarray(parts, rewritten):
    with xr.open_dataset(rewritten) as stored:
        share = stored["collapsed"].mean("record")
    assert share.isel(wall=0).isnull().all()
    expected = (parts["collapsed"] == 1).mean("record").isel(wall=1)
    ran = (parts["collapsed"] >= 0).any("record").isel(wall=1)
    np.testing.assert_allclose(share.isel(wall=1).where(ran), expected.where(ran))


def test_read_gives_integers_back(parts, rewritten):
    back = dataset.read(rewritten)
    assert back["collapsed"].dtype == np.int8
    xr.testing.assert_equal(back, parts)


def test_integers_without_missing_values_stay_integers(minimal):
    with xr.open_dataset(minimal / "earthquakes/check.nc") as stored:
        assert stored["collapsed"].dtype == np.int8


def test_plain_mean_of_collapses_is_a_share(minimal):
    with xr.open_dataset(minimal / "earthquakes.nc") as stored:
        share = stored["collapsed"].mean("record")
    histories = dataset.read(minimal / "earthquakes.nc")
    runs = (histories["collapsed"] >= 0).sum("record")
    collapses = (histories["collapsed"] == 1).sum("record")
    assert (runs == 0).any()
    np.testing.assert_allclose(share, collapses / runs.where(runs > 0))


# --- the minimal build ----------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*KINDS, *PARTS])
def test_built_dataset_has_the_names_of_its_kind(name, minimal):
    dataset.check(dataset.read(minimal / f"{name}.nc"), {**KINDS, **PARTS}[name])


@pytest.mark.parametrize("name", PARTS)
def test_part_says_so_in_its_title(name, minimal):
    assert xr.open_dataset(minimal / f"{name}.nc").attrs["title"].startswith("Part of ")


@pytest.mark.parametrize("name", DATASETS)
def test_index_coordinates_are_strictly_monotonic(name, minimal):
    """CF requires it of numbers, and `.sel` needs it; texts must differ."""
    data = dataset.read(minimal / name)
    for dimension in data.indexes:
        values = data[dimension].values
        assert len(set(values.tolist())) == values.size, dimension
        if values.dtype.kind in "iuf":
            steps = np.diff(values)
            assert (steps > 0).all() or (steps < 0).all(), dimension

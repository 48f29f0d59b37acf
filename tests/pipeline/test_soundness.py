"""Which results are not what their rules make in this tree: every way to be another's is noticed and named."""

import os
import shutil
from pathlib import Path

import made_up_results
import pytest

from rockdamp.pipeline import soundness
from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES
from rockdamp.storage import notes


@pytest.fixture(scope="module")
def expected():
    return made_up_results.minimal()


@pytest.fixture(scope="module")
def made(expected, tmp_path_factory):
    """A folder in which every result was made by its rule."""
    folder = tmp_path_factory.mktemp("made")
    made_up_results.make(folder, expected)
    return folder


@pytest.fixture
def folder(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "results"))


def reasons(folder, expected):
    return {os.path.relpath(path, folder): reason for path, reason in soundness.unsound(folder, expected)}


def test_each_stage_and_figure_has_a_result(expected):
    names = {result.name for result in expected}
    assert {f"figures/{name}" for name in FIGURES} | {"report", "claims", "coefficients"} <= names
    assert {stage.dataset for stage in STAGES.values() if stage.dataset and "{" not in stage.dataset} <= names
    assert {"decay/amplitude", "match/slenderness"} <= names
    assert len(names) == len(expected)


def test_results_that_their_rules_made_are_sound_wherever_they_lie(folder, expected):
    assert reasons(folder, expected) == {}
    moved = folder.rename(folder.with_name("moved"))
    assert reasons(moved, expected) == {}


def test_an_empty_folder_lacks_everything(tmp_path, expected):
    found = reasons(tmp_path / "nothing", expected)
    assert len(found) == sum(len(result.files) for result in expected)
    assert set(found.values()) == {"is missing"}


@pytest.mark.parametrize("file", ["equivalence.nc", "claims.csv", "errata.csv", "figures/fig1.png", "report.html"])
def test_a_file_that_was_changed_is_named(folder, expected, file):
    path = folder / file
    before = path.stat()
    path.write_text(path.read_text(encoding="utf-8")[::-1], encoding="utf-8")  # of the same size
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    found = reasons(folder, expected)
    assert found[file].startswith("is not what was written, by its digest")
    made_of = {"coefficients.csv", "claims.csv", "errata.csv"} if file == "equivalence.nc" else set()
    assert set(found) == {file} | made_of
    assert all(found[name] == "was made of another equivalence.nc" for name in made_of)


def test_a_result_of_another_config_or_of_other_sources_is_named(folder, expected):
    others = [result._replace(config_sha256="0" * 64) if result.name == "loops" else result for result in expected]
    assert reasons(folder, others) == {"loops.nc": "was made with another config"}
    others = [result._replace(code_version="0.1.0+0") if result.name == "loops" else result for result in expected]
    (reason,) = reasons(folder, others).values()
    assert reason.startswith("was made by other sources, ") and reason.endswith("; these are 0.1.0+0")


@pytest.mark.parametrize("text", [None, "", "{", "[]", '{"files": {}}', "null"])
def test_a_result_without_a_note_that_can_be_read_is_named(folder, expected, text):
    note = notes.place(folder, "figures/fig1")
    note.unlink() if text is None else note.write_text(text, encoding="utf-8")
    reason = "has no note of what it was made of"
    assert reasons(folder, expected) == {"figures/fig1.pdf": reason, "figures/fig1.png": reason}


def test_files_of_no_rule_are_named_and_results_of_another_config_below_are_not(folder, expected):
    (folder / "figures/old.png").touch()
    (folder / "README.md").touch()
    (folder / ".hidden").touch()
    shutil.copytree(folder, folder / "minimal", ignore=shutil.ignore_patterns("figures"))
    assert reasons(folder, expected) == {"figures/old.png": "is of no rule of this config"}


@pytest.mark.parametrize("odd", ["fifo", "folder", "link"])
def test_what_is_no_file_is_not_waited_for(folder, expected, odd):
    (folder / "loops.nc").unlink()
    make = {"fifo": os.mkfifo, "folder": os.mkdir, "link": lambda path: os.symlink("/dev/zero", path)}[odd]
    make(folder / "loops.nc")
    assert "digest" in reasons(folder, expected)["loops.nc"]


# --- states ---------------------------------------------------------------------------------------------------------


def newer(folder, states, expected):
    """Results that are older than their states: what Snakemake would build."""
    soundness.tell(folder, states, {}, expected)
    return {
        result.name
        for result in expected
        for file in result.files
        if (states / f"{result.name}.json").stat().st_mtime_ns > (folder / file).stat().st_mtime_ns
    }


def test_states_are_newer_than_what_is_another_s_and_older_than_the_rest(folder, tmp_path, expected):
    states = tmp_path / "states"
    assert newer(folder, states, expected) == set()
    path = folder / "loops.nc"
    before, text = path.stat(), path.read_text(encoding="utf-8")
    future = before.st_mtime_ns + 10**15
    for time in (before.st_mtime_ns, 0, future):
        path.write_text("another's", encoding="utf-8")
        os.utime(path, ns=(time, time))
        assert newer(folder, states, expected) == {"loops"}
        first = (states / "loops.json").read_text(encoding="utf-8")
        assert newer(folder, states, expected) == {"loops"}
        assert (states / "loops.json").read_text(encoding="utf-8") != first  # Snakemake passes over what is the same
    path.write_text(text, encoding="utf-8")
    assert newer(folder, states, expected) == set()


def test_digests_are_kept_and_found_again_by_what_no_copying_sets(folder, tmp_path, expected, monkeypatch):
    states = tmp_path / "states"
    newer(folder, states, expected)
    computed = []
    real = notes.digest
    monkeypatch.setattr(notes, "digest", lambda path: computed.append(str(path)) or real(path))
    newer(folder, states, expected)
    assert computed == []
    path = folder / "loops.nc"
    before = path.stat()
    path.write_text("x" * before.st_size, encoding="utf-8")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert newer(folder, states, expected) == {"loops"}
    assert computed == [str(path)]


def test_a_job_is_told_what_it_must_find(folder, expected, monkeypatch):
    monkeypatch.chdir(folder)
    states = soundness.STATES / "tagged"
    soundness.tell(folder, states, {"results": "here"}, expected)
    table, name = soundness.expectations(str(states / "match/amplitude.json"), {"results": "here"})
    assert name == "match/amplitude"
    (loops,) = [result for result in expected if result.name == "loops"]
    assert table["./loops.nc"].config_sha256 == loops.config_sha256 and table["./loops.nc"].kind == "loops"


def test_folders_of_one_name_have_tags_of_their_own():
    assert soundness.tag("results") == "results" and soundness.tag("results/minimal/") == "minimal"
    assert soundness.tag("results/a/same") == "a/same"
    tags = [soundness.tag(folder) for folder in ("a/same", "b/same", "/there/same", "../same", "same", "results/same")]
    assert len(set(tags)) == len(tags)
    assert not any(tag.startswith(("/", "..")) for tag in tags)

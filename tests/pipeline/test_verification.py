"""Results that the config and the sources at hand did not make: each is named."""

import os
import shutil
from pathlib import Path

import made_up_results
import pytest
import xarray as xr

from rockdamp.pipeline import verification
from rockdamp.pipeline.tables import FIGURES, STAGES
from rockdamp.storage.dataset import DatasetError

DAMAGED = "is not what the last complete build wrote, by its checksum"
UNLISTED = "is not in checksums.csv, the list of the last complete build"


@pytest.fixture(scope="module")
def expected():
    return made_up_results.minimal()


@pytest.fixture(scope="module")
def made(expected, tmp_path_factory):
    folder = tmp_path_factory.mktemp("made")
    made_up_results.make(folder, expected)
    return folder


@pytest.fixture
def folder(made, tmp_path):
    return Path(shutil.copytree(made, tmp_path / "results"))


def reasons(folder, expected):
    return {os.path.relpath(path, folder): reason for path, reason in verification.mismatches(folder, expected)}


def test_every_file_of_the_tables_has_an_origin(expected):
    assert {f"figures/{name}.{suffix}" for name in FIGURES for suffix in ("png", "pdf")} <= set(expected)
    assert {
        "report.html",
        "paper.html",
        "paper_claims.csv",
        "measured_claims.csv",
        "claims.csv",
        "claims.json",
        "errata.csv",
        "coefficients.csv",
    } <= set(expected)
    assert {stage.file for stage in STAGES.values() if "{" not in stage.file} <= set(expected)
    assert {"decay/amplitude.nc", "match/slenderness.nc", "earthquakes/records-1.nc"} <= set(expected)


def test_results_of_a_build_are_verified_wherever_they_lie(folder, expected):
    assert reasons(folder, expected) == {}
    assert reasons(folder.rename(folder.with_name("moved")), expected) == {}


def test_an_empty_folder_lacks_everything(tmp_path, expected):
    assert reasons(tmp_path / "nothing", expected) == dict.fromkeys(expected, "is missing")


@pytest.mark.parametrize("file", ["equivalence.nc", "claims.csv", "figures/fig1.png"])
def test_a_file_that_was_changed_is_named(folder, expected, file):
    path = folder / file
    before = path.stat()
    path.write_bytes(path.read_bytes()[::-1])  # of the same size
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))
    assert reasons(folder, expected) == {file: DAMAGED}


def test_a_result_of_another_config_or_of_other_sources_is_named(folder, expected):
    origin = expected["damping_force.nc"]
    other = {**expected, "damping_force.nc": origin._replace(config_sha256="0" * 64)}
    assert reasons(folder, other) == {"damping_force.nc": "was made with another config"}
    other = {**expected, "damping_force.nc": origin._replace(code_version="0.1.0+0")}
    assert reasons(folder, other) == {
        "damping_force.nc": f"was made by other sources, {origin.code_version}; these are 0.1.0+0"
    }


@pytest.mark.parametrize("text", [None, "file\ndamping_force.nc\n"])
def test_without_a_list_that_can_be_read_no_result_is_verified(folder, expected, text):
    listed = folder / "checksums.csv"
    listed.unlink() if text is None else listed.write_text(text, encoding="utf-8")
    assert reasons(folder, expected) == dict.fromkeys(expected, UNLISTED)


@pytest.mark.parametrize("attribute", ["config_sha256", "code_version"])
def test_a_dataset_that_states_another_origin_is_not_listed(folder, expected, attribute):
    path = folder / "damping_force.nc"
    xr.Dataset(attrs={**expected["damping_force.nc"]._asdict(), attribute: "0"}).to_netcdf(path)
    with pytest.raises(DatasetError, match=f"damping_force.nc states {attribute} 0; that of this run is .*; delete it"):
        verification.write_checksums(folder, expected)
    assert reasons(folder, expected) == {"damping_force.nc": DAMAGED}


def test_files_of_no_rule_are_named_and_results_of_another_config_below_are_not(folder, expected):
    (folder / "figures/old.png").touch()
    (folder / "README.md").touch()
    (folder / ".hidden").touch()
    shutil.copytree(folder, folder / "minimal", ignore=shutil.ignore_patterns("figures"))
    assert reasons(folder, expected) == {"figures/old.png": "is not a result of this config"}

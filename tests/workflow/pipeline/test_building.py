"""A build of the minimal config: every result, each by its name, the same bytes on one core as on two."""

import re
import shutil
from pathlib import Path

import pytest
import xarray as xr
from minimal_build import DATASETS, LOGS, OUTPUTS, RESULTS, WHOLE

from rockdamp.pipeline.tables import FIGURES

pytestmark = pytest.mark.long


def test_the_minimal_config_builds_every_dataset_table_and_figure(tree):
    built = {name.removeprefix(f"{RESULTS}/") for name in tree.digests(RESULTS)}
    assert set(OUTPUTS) <= built
    assert {Path(name).stem for name in built if name.startswith("figures/")} == set(FIGURES)


def test_the_minimal_config_leaves_the_full_results_alone(tree):
    outside = {name for name in tree.digests() if not name.startswith(RESULTS)}
    assert outside == {"results/decay/amplitude.nc"}
    assert (tree.place / "results/decay/amplitude.nc").read_text(encoding="utf-8") == "of the full config"


@pytest.mark.parametrize("name", DATASETS)
def test_a_dataset_opens_in_xarray_and_says_what_it_depends_on(tree, name):
    with xr.open_dataset(tree.place / RESULTS / name) as opened:
        assert opened.sizes
        assert re.fullmatch(r"[0-9a-f]{64}", opened.attrs["config_sha256"])
        assert re.fullmatch(r"\d+\.\d+\.\d+\+[0-9a-f]{16}", opened.attrs["code_version"])


def test_each_job_leaves_a_log_and_long_ones_tell_how_far_they_are(tree):
    logs = {str(path.relative_to(tree.place / LOGS)) for path in (tree.place / LOGS).rglob("*.log")}
    assert {"decay/amplitude.log", "match/amplitude.log", "response_lengths.log", "figures/fig1.log"} <= logs
    assert "%" in (tree.place / LOGS / "response_lengths.log").read_text(encoding="utf-8")


def test_after_a_build_nothing_is_left_to_do_and_every_stage_and_figure_can_be_asked_for_by_name(tree):
    run = tree.snakemake("--dry-run", "all", *(stage.name for stage in WHOLE), *FIGURES, "report")
    assert run.returncode == 0, run.stderr
    assert "Nothing to be done" in run.stdout + run.stderr


def test_one_core_gives_the_same_bytes_as_two(tree):
    overlay = "results: results/again\n"
    names = ["decay/amplitude.nc", "match/amplitude.nc", "response_lengths.nc"]
    run = tree.snakemake("--cores", "1", *(f"results/again/{name}" for name in names), overlay=overlay)
    assert run.returncode == 0, run.stderr
    again = tree.digests("results/again")
    shutil.rmtree(tree.place / "results/again")
    first = tree.digests(RESULTS)
    assert again == {f"results/again/{name}": first[f"{RESULTS}/{name}"] for name in names}


def test_the_report_names_what_it_stands_on(tree):
    html = (tree.place / RESULTS / "report.html").read_text(encoding="utf-8")
    assert str(tree.place) not in html
    for name in ("damping_force.nc", "match/amplitude.nc"):
        with xr.open_dataset(tree.place / RESULTS / name) as opened:
            assert opened.attrs["code_version"] in html and opened.attrs["config_sha256"][:16] in html


def test_snakemakes_own_report_shows_every_figure_with_caption_category_and_labels(tree):
    run = tree.snakemake("--report", "own-report.html")
    assert run.returncode == 0, run.stdout + run.stderr
    html = (tree.place / "own-report.html").read_text(encoding="utf-8")
    for name, figure in FIGURES.items():
        assert f"{RESULTS}/figures/{name}.png" in html
        assert figure.alternative in html
    for text in ("Figures of the paper", "Beyond the paper", "the mechanism", "peak against peak"):
        assert text in html

"""A damper and a study of cases, added to a copy of the tree as the how-to says, word by word."""

import re

import pytest
import xarray as xr
from howto_pages import edit, follow, make_tree, python

pytestmark = pytest.mark.long
NAME = "QVD"


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The copy, with the damper and what its commands printed."""
    tree = make_tree(tmp_path_factory.mktemp("damper") / "tree")
    edit(tree, "extend")
    tree.printed = follow(tree, "extend", edited=True)
    return tree


def test_decay_equivalent_and_respond_know_it(tree):
    assert len(re.findall(rf"^ *{NAME} +\d+ +[\d.]+ +0\.\d+$", tree.printed, flags=re.MULTILINE)) > 3
    (row,) = re.findall(rf"^ *0\.85 +{NAME} +(0\.\d+) +0\.\d+ +(0\.\d+) +-$", tree.printed, flags=re.MULTILINE)
    assert 0.5 < float(row[0]) / float(row[1]) < 2  # of least error, and by the closed form
    assert re.search(rf" {NAME} +0\.\d+ .* completed$", tree.printed, flags=re.MULTILINE)


def test_its_matched_decay_stands_beside_the_others(tree):
    with xr.open_dataset(tree.place / "results/minimal/damping_force.nc") as loops:
        assert NAME in loops["damping_model"].values
        one = loops.sel(damping_model=NAME)
        speed = abs(one["velocity"])
        force = abs(one["damping_force"]).where(speed > 0.05)
        ratio = force / speed**2
        assert float(ratio.max() / ratio.min()) == pytest.approx(1)  # C = c |v|
        assert float(one["damping_ratio"]) > 0.02
    assert (tree.place / "results/minimal/figures/fig3.png").stat().st_size > 1000


def test_the_suite_takes_it_up_without_an_edit(tree):
    assert int(re.search(r"(\d+) passed", tree.printed)[1]) > 50
    folders = ["tests/solvers/test_newmark.py", "tests/figures"]
    chosen = f"{NAME} or told_apart"
    told = python(tree, "-m", "pytest", "-q", "-p", "no:cacheprovider", *folders, "-k", chosen)
    assert int(re.search(r"(\d+) passed", told)[1]) > 5


def test_the_study_of_cases_has_its_dataset_and_prints_its_table(tree):
    with xr.open_dataset(tree.place / "results/minimal/plateau.nc") as study:
        ratio = study["median_intensity_ratio"].sel(assumption="b1 x 0.9")
        assert ratio["wall"].values.tolist() == ["all", "veneer", "parapet"]
        assert 0.8 < float(ratio.sel(wall="all")) < 1.05
        assert study.attrs["title"].startswith("A softer plateau")
    assert re.search(r"^b1 x 0\.9 +[\d.]+ +[\d.]+ +[\d.]+$", tree.printed, flags=re.MULTILINE)

"""A study and a figure, added to a copy of the tree as the how-tos say, word by word."""

import re

import pytest
import xarray as xr
from howto_pages import REPORT, edit, follow, make_tree, python

pytestmark = pytest.mark.long
RESULTS = "results/minimal"


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The copy, after both pages."""
    tree = make_tree(tmp_path_factory.mktemp("additions") / "tree")
    for page in ("add-a-study", "add-a-figure"):
        edit(tree, page)
        follow(tree, page, edited=True)
    return tree


@pytest.fixture(scope="module")
def page(tree):
    """The report of the copy, of made-up datasets: building all that the real one is given takes minutes."""
    return python(tree, "-c", REPORT)


def test_the_new_study_is_released_and_matched_as_the_others(tree):
    with xr.open_dataset(tree.place / RESULTS / "match/hinge.nc") as matched:
        assert matched["hinge_ratio"].values.tolist() == [0.6, 0.7]
        assert matched["hinge_ratio"].attrs["symbol"] == "h1/h"
        ratio = matched["damping_ratio"]
        assert float(abs(ratio.diff("hinge_ratio")).max()) == 0  # in tau the wall does not matter
        assert float(abs(matched["damping_ratio_fixed_seconds"].diff("hinge_ratio")).min()) > 0


def test_the_new_stage_computes_its_dataset(tree):
    with xr.open_dataset(tree.place / RESULTS / "periods.nc") as periods:
        assert periods["period"].dims == ("release_amplitude",)
        assert (periods["period"].diff("release_amplitude") > 0).all()
        assert periods.attrs["title"] == "Period of the undamped reference wall"


def test_the_new_figure_is_drawn(tree):
    for suffix in ("pdf", "png"):
        assert (tree.place / RESULTS / f"figures/fig_minima.{suffix}").stat().st_size > 1000


def test_a_column_is_in_its_dataset_and_in_the_figure_that_shows_it(tree):
    with xr.open_dataset(tree.place / RESULTS / "mechanism.nc") as mechanism:
        assert mechanism["rigid_strength"].attrs == {
            "units": "N",
            "long_name": "strength of the rigid wall",
            "symbol": "F0",
        }
    assert (tree.place / RESULTS / "figures/fig1.png").stat().st_size > 1000


def test_the_figure_stands_in_the_report(page):
    (figure,) = re.findall(r'<figure id="fig_minima">.*?</figure>', page, flags=re.DOTALL)
    assert "<h3>Local minima of the error</h3>" in figure
    assert "<figcaption>The most local minima of Err over all release amplitudes.</figcaption>" in figure
    assert page.index('id="fig_convergence"') < page.index('id="fig_minima"') < page.index('id="fig_amplitude"')


def test_the_report_needs_the_study_and_the_figure(tree):
    """A dry run that forces everything lists all that the report needs."""
    run = tree.snakemake("--dry-run", "--forceall", "report")
    table = (run.stdout + run.stderr).partition("Job stats:")[2].partition("total")[0]
    needed = dict(re.findall(r"^(\w+) +(\d+)$", table, flags=re.MULTILINE))
    assert needed["decay_study"] == needed["match_study"] == "5"
    assert needed["fig_minima"] == "1"

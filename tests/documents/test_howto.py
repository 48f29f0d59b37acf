"""The how-tos, word by word: the commands of each page are read from it and run in a copy of the tree."""

import re

import pytest
import xarray as xr
import yaml
from howto_pages import blocks, follow, make_tree, python
from repository import ROOT
from rounded_texts import holds

from rockdamp.constants import VISCOUS_MODELS


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return make_tree(tmp_path_factory.mktemp("howto") / "tree")


@pytest.mark.parametrize(
    ("name", "page"),
    [
        ("my-test", "your-test"),
        ("my-wall", "your-wall"),
        ("my-records", "your-records"),
    ],
)
def test_the_page_shows_the_example_as_it_is_shipped_in_ten_lines(name, page):
    shipped = (ROOT / f"examples/{name}.yaml").read_text(encoding="utf-8")
    assert blocks(page, "yaml")[-1] == shipped
    assert len(shipped.splitlines()) <= 10
    assert f"cp examples/{name}.yaml {name}.yaml" in "".join(blocks(page, "sh"))


@pytest.mark.long
def test_your_own_test_becomes_parameters_dampers_and_a_figure(tree):
    printed = follow(tree, "your-test")
    results = tree.place / "results/my-test"
    with xr.open_dataset(results / "calibration.nc") as fitted, xr.open_dataset(results / "validation.nc") as compared:
        told = [float(number) for number in re.findall(r"\d\.\d+", printed)]
        for value in fitted["estimate"].values:
            assert any(abs(number - value) < 1e-5 for number in told), value
        assert float(compared["restitution"]) == float(fitted["estimate"].sel(parameter="restitution"))
        assert set(compared["damping_model"].values) >= {"CR", "CDR"}
    assert (results / "figures/fig8.pdf").is_file() and (results / "figures/fig8.png").is_file()
    assert (results / "coefficients.csv").read_text(encoding="utf-8").count("\nCDR,") == 3
    fitted = python(tree, "-c", blocks("your-test", "python")[0])
    assert "restitution" in fitted and "of that of rigid mechanics" in printed
    assert (tree.place / "my-free-rocking.png").stat().st_size > 10_000
    assert "the best fit leaves" in printed and (tree.place / "my-fit.png").stat().st_size > 10_000


@pytest.mark.long
def test_your_own_wall_goes_through_the_studies(tree):
    printed = follow(tree, "your-wall")
    results = tree.place / "results/my-wall"
    config = yaml.safe_load((tree.place / "examples/my-wall.yaml").read_text(encoding="utf-8"))
    with xr.open_dataset(results / "match/amplitude.nc") as matched:
        amplitudes = config["studies"]["amplitude"]
        assert matched["release_amplitude"].values.tolist() == amplitudes
    for figure in ("fig5", "fig6", "fig7"):
        assert (results / f"figures/{figure}.png").is_file()
    assert "CDR" in printed and "frequency_parameter" in printed and "release_amplitude" in printed


def test_a_table_of_walls_becomes_a_table_of_answers(tree):
    shipped = (ROOT / "examples/my-walls.csv").read_text(encoding="utf-8")
    assert blocks("many-walls", "text")[0] == shipped
    printed = follow(tree, "many-walls")
    walls = [line.partition(",")[0] for line in shipped.splitlines()[1:]]
    assert all(wall in printed for wall in walls)
    answers = (tree.place / "my-answers.csv").read_text(encoding="utf-8").splitlines()
    assert [line.split(",")[0] for line in answers[1::2]] == walls
    with xr.open_dataset(tree.place / "my-answers.nc") as stored:
        assert stored["wall"].values.tolist() == walls
    ratios = (tree.place / "my-ratios.csv").read_text(encoding="utf-8").splitlines()
    assert [line.split(",")[0] for line in ratios[1 :: len(VISCOUS_MODELS)]] == walls


@pytest.mark.long
def test_a_wall_on_an_upper_floor_has_the_answers_that_the_page_shows(tree):
    printed = follow(tree, "upper-floors")
    shown = blocks("upper-floors", "text")
    assert len(shown) == 2 and all(holds(printed, block) for block in shown)
    medians = [float(median) for median in re.findall(r"  CR +- +([\d.]+)", printed)[:2]]
    page = (ROOT / "docs/howto/upper-floors.md").read_text(encoding="utf-8")
    assert f"is {medians[0]:.3g} g" in page and f"{medians[1]:.3g} g on the ground" in page
    assert f"by {medians[1] / medians[0]:.2f}." in page
    assert (tree.place / "my-wall.html").stat().st_size > 50_000
    assert (tree.place / "my-upper-walls.csv").is_file() and (tree.place / "my-floor-motion.csv").is_file()


def test_a_wall_under_a_timber_floor_has_the_answer_that_the_page_shows(tree):
    printed = follow(tree, "timber-floor")
    (shown,) = blocks("timber-floor", "text")
    assert holds(printed, shown) and (tree.place / "under-timber.csv").is_file()
    page = (ROOT / "docs/howto/timber-floor.md").read_text(encoding="utf-8")
    assert f"to {float(re.search(r'  CR +- +([0-9.]+)', printed)[1]):.3g} g." in page


@pytest.mark.long
def test_the_inputs_that_one_chooses_lead_to_answers_as_the_page_says(tree):
    printed = follow(tree, "choose-inputs")
    overburden = 2 + 3 * 6.0 / (0.24 * 1800 * 9.80665 / 1000 * 3.0)
    assert f"overburden over weight: {overburden:.2f}" in printed
    measured, rigid, impulsive = re.findall(r"^e = ([\d.]+): ", printed, flags=re.MULTILINE)[:3]
    assert float(rigid) > float(measured) and float(rigid) > float(impulsive)
    assert "median PGV" in printed and "median PGA" in printed and printed.count("dispersion") >= 6
    assert (tree.place / "my-wall.html").stat().st_size > 50_000


@pytest.mark.long
def test_your_own_records_shake_your_wall(tree):
    printed = follow(tree, "your-records")
    with xr.open_dataset(tree.place / "results/my-records/earthquakes.nc") as earthquakes:
        assert earthquakes["wall"].values.tolist() == ["mine"] and earthquakes.sizes["record"] == 1
        assert float(earthquakes["peak"].max()) > 0
        assert all(model in printed for model in map(str, earthquakes["damping_model"].values))

"""The table of damping ratios in the page: what its script reads is what the package reads, and is refused where it is.

The script runs under node where there is one.
"""

import json
from importlib.resources import files

import numpy as np
import pytest
import tabulate_ratios

import rockdamp as rd
from rockdamp.equivalence import tabulated
from rockdamp.report import ratio_table
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH, PAPER_MODELS


@pytest.fixture(scope="module")
def read(node, tmp_path_factory):
    """Read the table as the page does: settings to what is shown for each."""
    folder = tmp_path_factory.mktemp("node")
    table = files("rockdamp.report").joinpath("ratio_table.js").read_text(encoding="utf-8")
    (folder / "table.js").write_text(table, encoding="utf-8")
    (folder / "data.json").write_text(json.dumps(ratio_table.data(DEFAULT_RESPONSE_LENGTH)), encoding="utf-8")
    script = """
        const table = require("./table.js")(require("./data.json"));
        const settings = JSON.parse(require("fs").readFileSync(0, "utf8"));
        process.stdout.write(JSON.stringify(settings.map((setting) => table.read(setting.model, setting))));
    """
    return lambda settings: node(folder, script, settings)


def settings(softening, count=400):
    """Walls of the table's range and a little beyond, the corners and the middle of an edge among them."""
    beyond = np.random.default_rng(23).uniform(-0.03, 1.03, size=(5, count))
    beyond[:, 0], beyond[:, 1], beyond[4, 2] = 0.0, 1.0, 1.0
    beyond[3] = 1.0
    e, a1, b1, a3, x0 = tabulate_ratios.walls_at(beyond)
    if softening == "translated":
        a3 = np.random.default_rng(24).uniform(0.3, 1.0, size=count)
        a1, b1, x0 = a1 * a3, b1 * a3, x0 * a3
    return e, a1, b1, a3, x0


@pytest.mark.parametrize("softening", ["steeper", "translated"])
def test_the_page_reads_the_packages_ratios_and_refuses_where_it_refuses(read, softening):
    e, a1, b1, a3, x0 = settings(softening)
    curve = rd.TrilinearCurve(a1, b1, a3, softening)
    names = ("e", "a1", "b1", "a3", "x0")
    given = [
        {**dict(zip(names, map(float, wall), strict=True)), "softening": softening}
        for wall in zip(e, a1, b1, a3, x0, strict=True)
    ]
    for model in PAPER_MODELS:
        told = read([{**wall, "model": model} for wall in given])
        ratio, refusal = (function(curve, model, e, x0) for function in (rd.damping_ratio_table, rd.table_refusal))
        assert [wall["refusal"] for wall in told] == refusal.tolist()
        # The page draws a cubic through the four nearest nodes, the package a spline through all of them.
        shown = [np.nan if wall["xi"] is None else wall["xi"] for wall in told]
        np.testing.assert_allclose(shown, ratio, rtol=tabulated.LARGEST_ERROR / 2)
        assert set(refusal) >= {"", rd.table_refusal(curve, model, 0.6, x0)[0]} and np.isfinite(ratio).mean() > 0.5


def test_a_wall_of_steeper_softening_that_ends_early_is_refused_on_the_page(read):
    wall = {"model": "CDR", "e": 0.85, "a1": 0.04, "b1": 0.85, "a3": 0.9, "softening": "steeper", "x0": 0.5}
    early, whole = read([wall, {**wall, "a3": 1}])
    assert early["xi"] is None and early["refusal"].startswith(
        "ultimate_displacement_ratio (a3) must be 1 with steeper softening"
    )
    answer = rd.damping_ratio_table(rd.TrilinearCurve(0.04, 0.85), "CDR", 0.85)
    assert whole["xi"] == pytest.approx(float(answer), rel=1e-3)


def test_a_page_over_another_length_of_the_response_has_no_table():
    assert ratio_table.data(DEFAULT_RESPONSE_LENGTH + 4) is None

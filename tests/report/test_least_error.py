"""The search of the page for the damping ratio of least error finds what the package finds. It runs under node."""

import re

import numpy as np
import pytest

import rockdamp as rd
from rockdamp.errors import InputError
from rockdamp.vocabulary import VISCOUS_MODELS

AGREES = 1e-4  # of the ratio


@pytest.fixture(scope="module")
def search(node, explorer_page, tmp_path_factory):
    """Search as the page does: a list of (setting, damper) to a list of what it finds."""
    html = explorer_page.read_text(encoding="utf-8")
    texts = re.findall(r'<script class="own">(.*?)</script>', html, re.S)
    data = re.search(r'<script type="application/json" id="explorer-data">(.*?)</script>', html, re.S)[1]
    folder = tmp_path_factory.mktemp("node")
    for file, names in {
        "form.js": ("const dampingFormulas", "function closedForm("),
        "decay.js": ("function freeDecays(",),
        "search.js": ("function leastError(",),
    }.items():
        script = "\n".join(next(text for text in texts if name in text) for name in names)
        (folder / file).write_text(script, encoding="utf-8")
    (folder / "data.json").write_text(data, encoding="utf-8")
    script = """
        const data = require("./data.json");
        const form = require("./form.js")(data.constants);
        const searcher = require("./search.js")(form, require("./decay.js")(form), data.search);
        const asked = JSON.parse(require("fs").readFileSync(0, "utf8"));
        const search = ([wall, model]) => searcher.search(wall, model, data.solver.step, data.solver.compared);
        process.stdout.write(JSON.stringify(asked.map(search)));
    """
    return lambda asked: node(folder, script, asked)


def settings(count):
    """Random walls of the explorer's range whose curves exist, with a release and e each."""
    random = np.random.default_rng(31)
    while count:
        a1, b1, a3 = random.uniform(0.01, 0.3), random.uniform(0.3, 0.95), random.uniform(0.6, 1.0)
        softening = str(random.choice(["steeper", "translated"]))
        try:
            rd.TrilinearCurve(a1, b1, a3, softening)
        except InputError:
            continue
        count -= 1
        x0, e = random.uniform(0.3, 0.8) * a3, random.uniform(0.7, 0.98)
        yield {"a1": a1, "b1": b1, "a3": a3, "softening": softening, "x0": x0, "e": e}


def test_the_page_finds_the_ratios_of_least_error_that_the_package_finds(search):
    walls = [{"a1": 0.04, "b1": 0.85, "a3": 1.0, "softening": "steeper", "x0": 0.5, "e": 0.85}, *settings(11)]
    told = iter(search([(wall, model) for wall in walls for model in VISCOUS_MODELS]))
    for wall in walls:
        found = rd.equivalent(
            wall["e"], wall["a1"], wall["b1"], wall["a3"], wall["softening"], release_amplitude=wall["x0"]
        )
        for row in found:
            page = next(told)
            assert page["refusal"] == ""
            assert page["xi"] == pytest.approx(row["damping_ratio"], rel=AGREES), (wall, row["damping_model"])


def test_without_loss_the_ratio_is_zero_and_before_the_first_impact_there_is_none(search):
    study = {"a1": 0.04, "b1": 0.85, "a3": 1.0, "softening": "steeper", "x0": 0.5, "e": 0.85}
    late = {**study, "b1": 0.012}
    lossless, none = search([({**study, "e": 1}, "CDR"), (late, "CDR")])
    assert lossless == {"xi": 0, "refusal": ""}
    assert none["xi"] is None and "no minimum" in none["refusal"]

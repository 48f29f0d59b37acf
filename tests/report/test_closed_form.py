"""The closed form in the page's JavaScript: what it computes is what the package computes.

It runs under node where there is one.
"""

import re

import numpy as np
import pytest

from rockdamp.equivalence.closed_form import damping_ratio_energy, giannini_masiani
from rockdamp.errors import InputError
from rockdamp.mechanics.curve import TrilinearCurve
from rockdamp.mechanics.damping import Damping
from rockdamp.plausibility import as_meant
from rockdamp.vocabulary import PAPER_MODELS, PRESETS, RECOMMENDED, SOFTENING

KNOWN = (*PAPER_MODELS, "ECD", RECOMMENDED)  # to the script; of another name it draws nothing


@pytest.fixture(scope="module")
def run(node, explorer_page, tmp_path_factory):
    """Call functions of the closed form as the page holds it: a list of (name, arguments) to a list of results."""
    html = explorer_page.read_text(encoding="utf-8")
    texts = re.findall(r'<script class="own">(.*?)</script>', html, re.S)
    form = "\n".join(next(text for text in texts if name in text) for name in ("const dampingFormulas", "closedForm("))
    data = re.search(r'<script type="application/json" id="explorer-data">(.*?)</script>', html, re.S)[1]
    folder = tmp_path_factory.mktemp("node")
    (folder / "closed_form.js").write_text(form, encoding="utf-8")
    (folder / "data.json").write_text(data, encoding="utf-8")
    script = """
        const form = require("./closed_form.js")(require("./data.json").constants);
        const calls = JSON.parse(require("fs").readFileSync(0, "utf8"));
        const told = calls.map(([name, args]) => form[name](...args.map((a) => (a.a1 && !a.bare ? form.curve(a) : a))));
        process.stdout.write(JSON.stringify(told));
    """
    return lambda calls: node(folder, script, calls)


@as_meant()
def curves(count=60):
    """Random valid curves of both variants with an amplitude and e each, and the presets."""
    random = np.random.default_rng(7)
    found = [
        (a1, b1, 1.0, softening, x0, 0.85)
        for b1, a1 in PRESETS.values()
        for softening in SOFTENING
        for x0 in (0.03, 0.7)
    ]
    while len(found) < count:
        a1, b1, a3, x0, e = random.uniform([0.005, 0.1, 0.5, 0.01, 0.5], [0.4, 0.95, 1.0, 0.99, 0.999])
        softening = SOFTENING[len(found) % 2]
        try:
            TrilinearCurve(a1, b1, a3, softening)
        except InputError:
            continue
        found.append((a1, b1, a3, softening, x0 * a3, e))
    return found


def named(a1, b1, a3, softening):
    return {"a1": a1, "b1": b1, "a3": a3, "softening": softening}


@as_meant()
def test_the_script_computes_the_packages_damping_ratios(run):
    """The same rule on the same nodes: to rounding."""
    cases = curves()
    told = run([("dampingRatio", [named(*case[:4]), model, case[5], case[4]]) for model in KNOWN for case in cases])
    for model, ratios in zip(KNOWN, np.reshape(told, (len(KNOWN), -1)), strict=True):
        for softening in SOFTENING:
            some = [index for index, case in enumerate(cases) if case[3] == softening]
            a1, b1, a3, x0, e = (np.array([cases[index][part] for index in some]) for part in (0, 1, 2, 4, 5))
            own = damping_ratio_energy(TrilinearCurve(a1, b1, a3, softening), model, e, x0)
            np.testing.assert_allclose(ratios[some], own, rtol=1e-11)


@as_meant()
def test_the_script_knows_the_curve_and_the_dampers(run):
    x = np.linspace(0.001, 1.0, 40)
    for case in (curves()[0], *curves()[-4:]):
        curve = TrilinearCurve(*case[:4])
        inside = x[x < float(curve.ultimate_displacement_ratio)]
        calls = [(name, [named(*case[:4]), at]) for name in ("force", "energy") for at in x]
        calls += [("speedAt", [named(*case[:4]), at, float(x[-1])]) for at in x]
        own = [*curve.force(x), *curve.energy(x), *np.sqrt(2 * (curve.energy(x[-1]) - curve.energy(x)))]
        for model in KNOWN:
            calls += [("coefficient", [named(*case[:4]), model, at, at / 3]) for at in inside]
            own += [*Damping(model, 1.0).coefficient(curve, inside, inside / 3)]
        np.testing.assert_allclose(run(calls), own, rtol=1e-11, atol=1e-14)
    assert run([("gianniniMasiani", [0.85])]) == [pytest.approx(float(giannini_masiani(0.85)), rel=1e-14)]


def accepted(values):
    try:
        TrilinearCurve(values["a1"], values["b1"], values["a3"], values["softening"])
    except InputError:
        return False
    return 0 < values["x0"] < values["a3"] and 0 < values["e"] <= 1


STEPS = {"e": 0.005, "a1": 0.005, "b1": 0.01, "a3": 0.01, "x0": 0.01}


@as_meant()
def test_a_value_is_kept_where_the_package_takes_it_and_moved_to_one_that_it_takes_where_not(run):
    random = np.random.default_rng(11)
    calls, given = [], []
    for a1, b1, a3, softening, x0, e in curves(40):
        values = {**named(a1, b1, a3, softening), "x0": x0, "e": e, "bare": True}
        for name, step in STEPS.items():
            for wanted in (*random.uniform(-0.2, 1.3, 6), 0.0, 1.0):
                calls.append(("clamp", [name, float(wanted), step, values]))
                given.append((name, float(wanted), values))
    moved = 0
    for told, (name, wanted, values) in zip(run(calls), given, strict=True):
        # What depends on the release is not asked of the curve: the page moves the release after the curve.
        free = {**values, "x0": 1e-6} if name != "x0" else values
        assert accepted({**free, name: told}), (name, wanted, told, values)
        assert told == wanted or not accepted({**free, name: wanted})
        moved += told != wanted
    assert 500 < moved < len(given) - 500

"""NRML 0.5, read back by the standard library, and by OpenQuake where it is installed."""

import math
from xml.etree import ElementTree

import numpy as np
import pytest
from scipy.stats import lognorm

from rockdamp.errors import InputError, InputWarning
from rockdamp.storage.nrml import NAMESPACE, UNITS, Collapse, text, write

WALLS = [
    Collapse("house 7, north-CR", 0.45, 0.4, [0.1, 0.3, 0.9], [0.0, 0.25, 1.0]),
    Collapse("undefined", math.nan, math.nan, [0.1, 0.3], [0.0, 0.0]),
]
IN = f"{{{NAMESPACE}}}"

pytestmark = pytest.mark.filterwarnings("ignore:white space in taxonomies")


def functions(content):
    model = ElementTree.fromstring(content.encode()).find(f"{IN}fragilityModel")
    assert model.find(f"{IN}limitStates").text == "collapse"
    return {function.get("id"): function for function in model.iterfind(f"{IN}fragilityFunction")}


@pytest.mark.parametrize(("measure", "factor"), [("PGV", 100.0), ("PGA", 1 / 9.80665)])
def test_mean_and_deviation_are_those_of_the_lognormal_in_openquakes_unit(measure, factor):
    found = functions(text(WALLS, measure, "m", "Walls."))
    continuous = found["house_7__north-CR"]
    assert (continuous.get("format"), continuous.get("shape")) == ("continuous", "logncdf")
    assert continuous.find(f"{IN}imls").get("imt") == measure
    stated = continuous.find(f"{IN}params")
    law = lognorm(s=0.4, scale=0.45 * factor)
    assert float(stated.get("mean")) == pytest.approx(law.mean(), rel=1e-12)
    assert float(stated.get("stddev")) == pytest.approx(law.std(), rel=1e-12)


def test_stripes_are_a_discrete_function_and_where_no_curve_is_defined_the_only_one():
    found = functions(text(WALLS, "PGV", "m", "Walls."))
    assert set(found) == {"house_7__north-CR", "house_7__north-CR-discrete", "undefined-discrete"}
    discrete = found["house_7__north-CR-discrete"]
    assert [float(level) for level in discrete.find(f"{IN}imls").text.split()] == pytest.approx([10, 30, 90])
    assert [float(share) for share in discrete.find(f"{IN}poes").text.split()] == [0.0, 0.25, 1.0]


def test_a_taxonomy_that_is_an_identifier_keeps_it_whatever_others_become():
    walls = [Collapse(name, 0.45, 0.4, [0.1, 0.9], [share, 1.0]) for name, share in (("A B-CR", 0.1), ("A_B-CR", 0.2))]
    for order in (walls, walls[::-1]):
        found = functions(text(order, "PGV", "m", "Walls."))
        kept = found["A_B-CR-discrete"].find(f"{IN}poes").text.split()
        assert float(kept[0]) == 0.2 and "A_B-CR_" in found


def test_a_taxonomy_stays_as_it_was_typed_beside_its_id_but_for_white_space():
    typed = ["MUR+CLBRS/LWAL/H:2", "A B", "A_B", "5<7&8"]
    walls = [Collapse(name, 0.45, 0.4, [0.1, 0.9], [0.1, 1.0]) for name in typed]
    with pytest.warns(InputWarning, match="as in 'A B', is written as _"):
        found = functions(text(walls, "PGV", "m", "Walls."))
    assert len(found) == 2 * len(typed)
    written = ["MUR+CLBRS/LWAL/H:2", "A_B", "A_B", "5<7&8"]
    assert [function.get("taxonomy") for function in found.values()] == [name for name in written for _ in range(2)]


def test_a_file_is_whole_and_names_the_measure_with_its_unit(tmp_path):
    write(tmp_path / "f.xml", text(WALLS, "PGA", "f", "Walls <of & one> town."))
    description = ElementTree.parse(tmp_path / "f.xml").getroot().find(f"{IN}fragilityModel/{IN}description").text
    assert description == "Walls <of & one> town. PGA in g."
    assert [path.name for path in tmp_path.iterdir()] == ["f.xml"]


@pytest.mark.peers
@pytest.mark.filterwarnings("ignore")  # of OpenQuake's own imports
@pytest.mark.parametrize("measure", UNITS)
def test_openquake_reads_the_same_fragility(measure, tmp_path):
    nrml = pytest.importorskip("openquake.hazardlib.nrml", reason="OpenQuake is not installed", exc_type=ImportError)
    pytest.importorskip(
        "openquake.risklib.read_nrml", exc_type=ImportError
    )  # which teaches the former fragility models
    path = tmp_path / "fragility.xml"
    write(path, text(WALLS, measure, "fragility", "Walls."))
    model = nrml.to_python(str(path))
    assert type(model).__name__ == "FragilityModel" and model.limitStates == ["collapse"]
    assert {imt for imt, _ in model} == {measure} and len(model) == 3
    _, factor = UNITS[measure]
    level = factor * np.array([0.2, 0.45, 0.8])
    (continuous,), (discrete,) = (
        model[measure, name].build(["collapse"]) for name in ("house_7__north-CR", "house_7__north-CR-discrete")
    )
    np.testing.assert_allclose(continuous(level), lognorm(s=0.4, scale=0.45 * factor).cdf(level), rtol=1e-9)
    np.testing.assert_allclose(discrete(factor * np.array([0.3, 0.9])), [0.25, 1.0], rtol=1e-9)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"share": [0.0, -0.1]}, "share of collapses of 'a' is -0.1; it must be between 0 and 1"),
        ({"share": [0.0, math.nan]}, "share of collapses of 'a' is nan"),
        ({"intensity": [0.3, 0.1]}, "intensity of 'a' is 0.1; it must be finite, at least 0 and rising"),
        ({"intensity": [], "share": []}, "'a' has 0 intensities"),
        ({"median": -1.0}, "median of 'a' is -1.0; it must be greater than 0"),
    ],
)
def test_what_is_no_fragility_is_refused(changes, message):
    right = {"name": "a", "median": 0.4, "dispersion": 0.3, "intensity": [0.1, 0.3], "share": [0.0, 0.5]}
    with pytest.raises(InputError, match=message):
        text([Collapse(**right | changes)], "PGV", "m", "")

"""What the report's explorer is given."""

import numpy as np
import pytest

from rockdamp.equivalence.closed_form import NODES, PLATEAU_PIECES, WEIGHTS
from rockdamp.report import interactive
from rockdamp.vocabulary import MODELS


def test_the_closed_form_is_given_the_packages_constants(content):
    given = interactive.data(content.datasets["explorer"], 0.85, 0.5)["constants"]
    assert given["nodes"] == NODES.tolist() and given["weights"] == WEIGHTS.tolist()
    assert given["plateau_pieces"] == PLATEAU_PIECES


def test_stored_decays_survive_their_rounding_and_a_collapse(content):
    import base64

    data = content.datasets["explorer"].copy(deep=True)
    data["displacement"][1, 2, 3, 40:] = np.nan
    given = interactive.data(data, 0.85, 0.5)["decays"]
    whole = np.frombuffer(base64.b64decode(given["displacement"]), "<i2").reshape(data["displacement"].shape)
    read = np.where(whole == given["missing"], np.nan, whole * given["scale"])
    assert np.array_equal(np.isnan(read), np.isnan(data["displacement"].values))
    np.testing.assert_allclose(read, data["displacement"], rtol=0, atol=0.5e-4 + 1e-12)
    assert given["points"] == data.sizes["tau"] and given["spacing"] == pytest.approx(0.05)


def test_the_explorer_starts_at_the_studys_curve(content):
    given = interactive.data(content.datasets["explorer"], 0.85, 0.5)
    assert given["start"] == {"e": 0.85, "x0": 0.5, "a1": 0.04, "b1": 0.85, "a3": 1.0, "softening": "steeper"}
    assert set(given["presets"]) == {"study", "new", "moderate", "severe"}


def test_dashes_of_the_screen_are_those_of_the_figures():
    assert interactive.dash("solid") == []
    assert interactive.dash((0, (3.0, 1.4))) == [6.0, 2.8]
    assert set(interactive.styles()) == set(MODELS)

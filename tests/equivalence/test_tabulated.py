"""The table of damping ratios: what it says against the matcher, where it must not be used, and its file."""

import csv
import json

import numpy as np
import pytest
import tabulate_ratios

import rockdamp as rd
from rockdamp.equivalence import matching, tabulated
from rockdamp.equivalence.closed_form import exact_ratio
from rockdamp.equivalence.minima import Cases
from rockdamp.errors import InputError
from rockdamp.vocabulary import DEFAULT_RESPONSE_LENGTH, PAPER_MODELS, PRESETS

CURVE = rd.TrilinearCurve(0.04, 0.85)
STEP = 0.005


def directly(curve, e, x0):
    """The damping ratios of least Err by the matcher, by model."""
    steps = round(DEFAULT_RESPONSE_LENGTH / STEP)
    cases = Cases.released(curve, x0, e, step=STEP, steps=steps)
    found = matching.solve(cases, PAPER_MODELS, steps, refinement=2)
    return {model: found[model].damping_ratio for model in PAPER_MODELS}


def differs(curve, e, x0):
    matched = directly(curve, e, x0)
    return np.array([rd.damping_ratio_table(curve, model, e, x0) / matched[model] - 1 for model in PAPER_MODELS])


def test_walls_drawn_at_random_have_the_ratios_that_the_matcher_finds():
    e, a1, b1, a3, x0 = tabulate_ratios.walls_at(np.random.default_rng(20).uniform(size=(5, 24)))
    off = np.abs(differs(rd.TrilinearCurve(a1, b1, a3), e, x0))
    assert np.isfinite(off).mean() > 0.8
    assert np.nanmax(off) < tabulated.LARGEST_ERROR and np.nanmedian(off) < 0.1 * tabulated.LARGEST_ERROR


def test_a_curve_of_translated_softening_is_one_of_a3_1_on_another_scale():
    a3 = np.array([0.85, 0.6])
    curve = rd.TrilinearCurve(0.05 * np.ones(2), 0.45 * np.ones(2), a3, "translated")
    e, x0 = np.array([0.88, 0.8]), np.array([0.4, 0.3])
    assert np.abs(differs(curve, e, x0)).max() < tabulated.LARGEST_ERROR
    scaled = rd.TrilinearCurve(0.05 / a3, 0.45 / a3)
    for model in PAPER_MODELS:
        own = rd.damping_ratio_table(scaled, model, e, x0 / a3)
        np.testing.assert_array_equal(rd.damping_ratio_table(curve, model, e, x0), own)


def test_the_table_answers_for_every_named_curve():
    b1, a1 = np.array(list(PRESETS.values())).T
    for model in PAPER_MODELS:
        ratio = rd.damping_ratio_table(rd.TrilinearCurve(a1, b1), model, np.array([[0.8], [0.9]]))
        assert ratio.shape == (2, len(PRESETS)) and np.isfinite(ratio).all()


def test_the_studys_curve_is_answered_for_at_every_e_of_the_study():
    e = np.arange(0.70, 0.981, 0.005)
    for model in PAPER_MODELS:
        assert np.isfinite(rd.damping_ratio_table(CURVE, model, e)).all()


def test_dampers_that_lose_the_same_from_every_amplitude_need_no_table():
    far = rd.TrilinearCurve(0.001, 0.95)
    assert rd.damping_ratio_table(far, "ecd", [0.3, 0.85], 0.9) == pytest.approx(exact_ratio([0.3, 0.85]))
    assert rd.damping_ratio_table(far, "ECD16", 0.5) == rd.Damping.of_restitution(0.5, "ECD16").damping_ratio
    assert rd.table_refusal(far, "ECD", [0.3, 0.85]).tolist() == ["", ""]


def test_a_point_of_the_unit_box_and_its_wall_are_each_others_inverse():
    unit = np.random.default_rng(3).uniform(size=(5, 50))
    np.testing.assert_allclose(tabulated.unit_of(*tabulate_ratios.walls_at(unit)), unit, atol=1e-12)


def test_between_nodes_the_table_is_read_by_a_cubic_in_each_variable():
    shape = (4, 5, 4, 4, 6)
    rng = np.random.default_rng(8)
    cubics = [np.polynomial.Polynomial(rng.normal(size=4)) for _ in shape]
    values = [cubic(np.linspace(0, 1, nodes)) for cubic, nodes in zip(cubics, shape, strict=True)]
    table = tabulated.Table(np.einsum("a,b,c,d,e->abcde", *values), np.zeros(()))
    at = np.concatenate([rng.uniform(size=(5, 6)), [[0, 1]] * 5], axis=1)
    exact = np.prod([cubic(axis) for cubic, axis in zip(cubics, at, strict=True)], axis=0)
    np.testing.assert_allclose(table.read(at), exact, rtol=1e-10)


OUTSIDE = {
    "restitution (e) is 0.6; it must be between 0.7 and 0.99": (CURVE, 0.6, 0.5),
    "strength_ratio (b1) is 0.95; it must be between 0.4 and 0.9": (rd.TrilinearCurve(0.03, 0.95), 0.85, 0.5),
    "yield_displacement_ratio (a1) is 0.14; it must be between 0.02 and": (rd.TrilinearCurve(0.14, 0.85), 0.85, 0.5),
    "release_amplitude is 0.15; it must be between 0.1 + 1.5 a1 and 0.8 a3": (CURVE, 0.85, 0.15),
}


@pytest.mark.parametrize("said", OUTSIDE)
def test_one_wall_outside_the_range_is_refused_with_its_value_and_among_many_it_is_nan_with_a_reason(said):
    curve, e, x0 = OUTSIDE[said]
    with pytest.raises(InputError) as refused:
        rd.damping_ratio_table(curve, "SDR", e, x0)
    assert str(refused.value).startswith(said)
    assert np.isnan(rd.damping_ratio_table(curve, "SDR", [e], x0)).all()
    name, allowed = said.split(" is ")[0], said.split("; ")[1]
    assert rd.table_refusal(curve, "SDR", [e], x0)[0].startswith(f"{name} {allowed.removeprefix('it ')}")


ENDS = {  # a wall at an end of the range, and how far beyond it is refused: e, a1, b1, a3, release
    "e from below": ((0.70, 0.04, 0.85, 1.0, 0.5), (-1e-4, 0, 0, 0, 0)),
    "e from above": ((0.99, 0.04, 0.85, 1.0, 0.5), (1e-4, 0, 0, 0, 0)),
    "a1": ((0.85, 0.02, 0.85, 1.0, 0.5), (0, -1e-5, 0, 0, 0)),
    "b1 from below": ((0.85, 0.04, 0.4, 1.0, 0.5), (0, 0, -1e-4, 0, 0)),
    "b1 from above": ((0.85, 0.04, 0.9, 1.0, 0.5), (0, 0, 1e-4, 0, 0)),
    "a3": ((0.85, 0.04, 0.85, 0.7, 0.4), (0, 0, 0, -1e-4, 0)),
    "release from below": ((0.85, 0.04, 0.85, 1.0, 0.1 + 1.5 * 0.04), (0, 0, 0, 0, -1e-4)),
    "release from above": ((0.85, 0.04, 0.85, 1.0, 0.8), (0, 0, 0, 0, 1e-4)),
}


@pytest.mark.parametrize("end", ENDS)
def test_the_table_reaches_to_the_ends_that_are_stated_and_no_further(end):
    at, beyond = (np.array(values) for values in ENDS[end])
    for values, answered in ((at, True), (at + beyond, False)):
        e, a1, b1, a3, x0 = values
        assert (rd.table_refusal(rd.TrilinearCurve(a1, b1, a3), "SDR", [e], x0)[0] == "") == answered


def test_a_cell_near_a_switch_is_refused_and_its_neighbours_answer():
    cells = tabulated.shipped("CDC").refused
    beside = np.argwhere(cells[..., :-1] & ~cells[..., 1:])[0]
    middle = (beside[:, None] + 0.5 + np.array([[0, 0], [0, 0], [0, 0], [0, 0], [0, 1]])) / np.array(cells.shape)[
        :, None
    ]
    e, a1, b1, a3, x0 = tabulate_ratios.walls_at(middle)
    curve = rd.TrilinearCurve(a1, b1, a3)
    assert np.isnan(rd.damping_ratio_table(curve, "CDC", e, x0)).tolist() == [True, False]
    why = rd.table_refusal(curve, "CDC", e, x0)
    assert "Err has a second minimum" in why[0] and why[1] == ""
    with pytest.raises(InputError, match="this wall, under CDC: it must be matched"):
        rd.damping_ratio_table(rd.TrilinearCurve(a1[0], b1[0], a3[0]), "CDC", e[0], x0[0])


def test_a_wall_has_one_ratio_whatever_stands_beside_it(monkeypatch):
    e, a1, b1, a3, x0 = tabulate_ratios.walls_at(np.random.default_rng(4).uniform(size=(5, 9)))
    curve = rd.TrilinearCurve(a1, b1, a3)
    together = rd.damping_ratio_table(curve, "CDR", e, x0)
    monkeypatch.setattr(tabulated, "AT_ONCE", 4)
    np.testing.assert_array_equal(rd.damping_ratio_table(curve, "CDR", e, x0), together)


def test_a_file_holds_the_table_to_the_bit_and_the_shipped_one_is_of_this_range(tmp_path):
    tables = {model: tabulated.shipped(model) for model in PAPER_MODELS}
    tabulate_ratios.write(tables, tabulate_ratios.protocol(), tmp_path / "table.npz")
    with np.load(tmp_path / "table.npz") as other, np.load(tabulated.FILE) as shipped:
        assert set(other) == set(shipped)
        for name in set(other) - {"protocol"}:
            np.testing.assert_array_equal(other[name], shipped[name])
        stated, wanted = (json.loads(str(file["protocol"])) for file in (shipped, other))
    assert {name: stated[name] for name in wanted} == wanted


def test_the_stated_error_was_not_exceeded_by_any_wall_drawn_or_searched():
    text = (tabulate_ratios.PLACE / "ratios-check.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    assert [row["damping_model"] for row in rows] == list(PAPER_MODELS)
    for row in rows:
        assert float(row["largest"]) <= float(row["largest_searched"]) <= tabulated.LARGEST_ERROR
        assert int(row["walls"]) >= 4000 and int(row["searched"]) >= 500

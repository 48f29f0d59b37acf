"""Many walls: each is what it is alone, a bad one stops no other, and what is written of them."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from wall_table import TABLE

import rockdamp as rd
from rockdamp.assessment import assess
from rockdamp.assessment.answers import ANSWER_COLUMNS, tabulate_walls
from rockdamp.assessment.assess import assess_rows
from rockdamp.assessment.table import read_walls
from rockdamp.storage import dataset

LAW = {"loss_exponent": 0.26, "reference_amplitude": 0.3}


@pytest.fixture(scope="module")
def records(motions):
    """Four stations, the fewest that have an interval."""
    return motions[:8]


@pytest.fixture(scope="module")
def rows(tmp_path_factory):
    path = tmp_path_factory.mktemp("walls") / "walls.csv"
    path.write_text(TABLE, encoding="utf-8")
    return read_walls(path)


@pytest.fixture(scope="module")
def answers(rows, records):
    return assess_rows(rows, records, "PGV", 0.5)


@pytest.mark.parametrize("number", [0, 2, 3, 4, 5], ids=["a", "b", "c", "front", "floor"])
def test_each_wall_is_what_assess_says_of_it_alone(number, rows, answers, records):
    row = rows[number]
    supports = rd.floor_motions(records, diaphragm=row.diaphragm) if row.diaphragm else records
    alone = rd.assess(row.wall, row.curve, supports, pgv=0.5, restitution=row.restitution)
    answer = answers.sel(wall=row.id, damping_model=alone["damping_model"])
    assert answer["row_error"].item() == ""
    for name in ("collapses", "peak_median"):
        np.testing.assert_array_equal(answer[name], alone[name][:, 0])
    for name in ("rocking_onset", "damping_ratio", "restitution", "records"):
        np.testing.assert_array_equal(answer[name], alone[name])
    for name in ("stripe_collapses", "unconverged"):
        np.testing.assert_array_equal(answer[name], alone[name])
    for name in ("median_pgv", "dispersion", "median_uncertainty", "dispersion_uncertainty"):
        np.testing.assert_allclose(answer[name], alone[name], rtol=1e-8)


def test_a_bad_row_has_its_error_and_no_value(rows, answers):
    answer = answers.sel(wall="bad")
    assert answer["row_error"].item() == rows[1].error
    assert np.isnan(answer["dispersion"]).all()
    assert (answer["collapses"] == -1).all()


def test_a_one_sided_wall_has_no_second_damper(answers):
    assert answers["damper_family"].values.tolist() == ["CR", "BAND"]
    collapses = answers["collapses"].sel(wall="front")
    assert collapses.sel(damping_model="BAND") == -1
    assert collapses.sel(damping_model="CR") >= 0


def test_how_many_run_at_once_changes_nothing(rows, answers, records):
    xr.testing.assert_identical(assess_rows(rows, records, "PGV", 0.5, chunk=1), answers)


def test_a_wall_that_cannot_be_run_stops_no_other(rows, answers, records, monkeypatch):
    run_intensities = assess.run_intensities

    def refuse(specimens, *arguments, **options):
        if np.any(np.asarray(getattr(specimens[0].wall, "thickness", 0)) == 0.30):
            raise rd.InputError("a history would take too long")
        return run_intensities(specimens, *arguments, **options)

    monkeypatch.setattr(assess, "run_intensities", refuse)
    others = assess_rows(rows, records, "PGV", 0.5)
    refused = others.sel(wall="c")
    assert refused["row_error"].item() == "a history would take too long"
    assert (refused["collapses"] == -1).all()
    assert np.isnan(refused["restitution"])
    walls = ["a", "b", "front"]
    xr.testing.assert_identical(others.sel(wall=walls), answers.sel(wall=walls))


def test_a_table_of_bad_rows_alone_is_refused(rows, records):
    with pytest.raises(rd.InputError, match=f"{rows[1].id}: thickness is empty"):
        assess_rows(rows[1:2], records, "PGV", 0.5)


@pytest.mark.parametrize("tail", [-1.0, 1e6])
def test_a_tail_beyond_its_bounds_is_refused_for_all(tail, rows, records):
    with pytest.raises(rd.InputError, match="tail"):
        assess_rows(rows, records, "PGV", 0.5, tail=tail)


@pytest.fixture(scope="module")
def upstairs(rows, records):
    """Four walls in a building, under a flexible floor, with a loss law that one cannot have."""
    short = replace(rows[0], id="short", curve=rd.TrilinearCurve(0.02, 0.85, 0.2))
    building = rd.Building(0.25, 3, 3)
    options = {"building": building, "diaphragm": rd.Diaphragm(0.3), **LAW}
    return assess_rows([*rows[:4], short], records[:4], "PGA", 3.0, **options)


@pytest.mark.parametrize("number", [0, 2], ids=["wall", "parapet"])
def test_building_floor_and_law_are_those_of_all_rows(number, rows, records, upstairs):
    row = rows[number]
    is_parapet = isinstance(row.wall, rd.Parapet)
    supports = rd.floor_motions(records[:4], rd.Building(0.25, 3, 3), is_parapet, rd.Diaphragm(0.3))
    alone = rd.assess(row.wall, row.curve, supports, pga=3.0, restitution=row.restitution, **LAW)
    stripes = upstairs["stripe_collapses"].sel(wall=row.id)
    np.testing.assert_array_equal(stripes, alone["stripe_collapses"])


def test_a_law_that_a_wall_cannot_have_is_its_error(upstairs):
    assert "reference_amplitude" in upstairs["row_error"].sel(wall="short").item()


# --- the table that is written --------------------------------------------------------------------


def test_the_table_has_a_row_for_each_wall_and_damper(answers):
    table = tabulate_walls(answers)
    columns = [*ANSWER_COLUMNS[:2], "pgv", *ANSWER_COLUMNS[2:]]
    assert all(list(row) == columns for row in table)
    names = [(row["id"], row["damping_model"]) for row in table]
    assert names[:4] == [("a", "CR"), ("a", "BAND"), ("bad", None), ("b", "CR")]
    assert [name for name in names if name[0] == "front"] == [("front", "CR")]


def test_the_table_holds_the_values_of_the_answer(answers):
    row = tabulate_walls(answers)[0]
    assert row["median_intensity"] == answers["median_pgv"].values[0, 0]
    assert (row["pgv"], row["records"], row["reason"]) == (0.5, 8, None)


@pytest.mark.parametrize(("measure", "unit"), [("pgv", "m s-1"), ("pga", "m s-2")])
def test_the_table_states_the_unit_of_the_median(measure, unit, answers):
    renamed = answers.rename({name: name.replace("pgv", measure) for name in ["median_pgv", "pgv"]})
    assert {row["intensity_unit"] for row in tabulate_walls(renamed) if not row["error"]} == {unit}


def test_a_row_with_an_error_has_no_value(answers):
    row = tabulate_walls(answers)[2]
    assert "thickness is empty" in row["error"]
    assert row["collapses"] is None
    assert row["intensity_unit"] is None


def test_the_table_states_the_loss_law(upstairs):
    exponents = {row["loss_exponent"] for row in tabulate_walls(upstairs) if not row["error"]}
    assert exponents == {0.26}


def test_a_row_without_a_fragility_says_why_by_its_own_counts(answers):
    """One of four pairs has shares that fall; those of the others are separated."""
    few = answers.sel(wall=["a", "b"]).copy(deep=True)
    is_first = np.arange(few.sizes["stripe"]) < 1
    few["stripe_collapses"][:] = np.where(is_first, 0, 8)
    falling = {"wall": "a", "damping_model": "BAND"}
    few["stripe_collapses"].loc[falling] = np.where(is_first, 8, 0)
    reasons = {(row["id"], row["damping_model"]): row["reason"] for row in tabulate_walls(few)}
    assert "does not rise" in reasons.pop(("a", "BAND"))
    assert len(reasons) == 3
    assert all("none below it" in reason for reason in reasons.values())


@pytest.mark.parametrize("kind", ["batch", "assessment"])
def test_answers_are_written_as_the_glossary_says(kind, answers, answer, tmp_path):
    written = {"batch": answers, "assessment": answer}[kind]
    dataset.write(written, tmp_path / "walls.nc", kind, config={}, code_version="test")
    read = dataset.read(tmp_path / "walls.nc")
    np.testing.assert_array_equal(read["dispersion"], written["dispersion"])
    assert read["damper_family"].values.tolist() == ["CR", "BAND"]

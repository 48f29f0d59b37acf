"""What runs again after a change of the config, the code or the data: what depends on it, and nothing else."""

import pytest
from minimal_build import OUTPUTS, RESULTS
from pipeline_graph import jobs_after, readers

from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES
from rockdamp.storage import yaml_file

pytestmark = pytest.mark.workflow

# Some that read each of them, by hand; the tables say who else, and what comes after.
CHANGES = {
    "figures: {resolution: 90}": list(FIGURES),
    "validation: {restitution: 0.84}": ["validation", "accuracy"],
    "studies: {slenderness: {slenderness: [15, 22]}}": ["decay/slenderness", "match/slenderness", "accuracy"],
    "studies: {cracked_stiffness: {yield_displacement_ratio: [0.02, 0.05, 0.17]}}": [  # one a1
        "decay/cracked_stiffness",
        "match/cracked_stiffness",
        "accuracy",
    ],
    "restitution: {start: 0.70}": ["decay/amplitude", "decay/overburden"],
    "matching: {response_length: 9}": [
        "match/amplitude",
        "damping_force",
        "amplitude_dependence",
        "pulses",
        "earthquakes/walls",
        "accuracy",
    ],
    "curve: {yield_displacement_ratio: 0.05}": ["decay/amplitude", "response_lengths", "damping_force", "mechanism"],
    "earthquakes: {bootstrap: {replicates: 60}}": ["comparison"],
    "population: {bootstrap: {replicates: 30}}": ["population"],
}


@pytest.mark.parametrize("overlay", CHANGES)
def test_a_change_of_the_config_runs_what_depends_on_it_and_nothing_else(tree, overlay):
    reading = readers(yaml_file.load(overlay))
    assert set(CHANGES[overlay]) <= set(reading)
    assert tree.planned(overlay) == jobs_after(*reading, "report")  # which shows the config


def test_a_partial_run_after_a_change_of_the_config_leaves_the_rest(tree):
    before, overlay = tree.digests(RESULTS), "response_lengths: {step: 5}"
    run = tree.snakemake(overlay=overlay)
    assert run.returncode == 0, run.stderr
    after = tree.digests(RESULTS)
    changed = {name for name in after if before.get(name) != after[name]}
    # the claims are judged by the response lengths
    expected = {
        f"{RESULTS}/{name}"
        for name in ("response_lengths.nc", "claims.csv", "claims.json", "errata.csv", "checksums.csv")
    }
    assert changed & {f"{RESULTS}/{name}" for name in OUTPUTS} == expected
    assert tree.planned(overlay) == {}
    assert tree.snakemake().returncode == 0  # back to the first state, for the other tests
    assert tree.digests(RESULTS) == before


EDITS = {
    "src/rockdamp/studies/response_lengths.py": (
        "PAPER_RANGE = (0.80",
        "PAPER_RANGE = (0.81",
        jobs_after("response_lengths"),
    ),
    "src/rockdamp/storage/variables.yaml": ("common:", "# edited\ncommon:", jobs_after(*STAGES)),  # attributes
    "src/rockdamp/figures/style.py": ("coefficient of restitution $e$", "restitution $e$", jobs_after(*FIGURES)),
    "src/rockdamp/figures/convergence.py": ("figure", "figure ", jobs_after("fig_convergence")),
    "src/rockdamp/mechanics/trilinear.py": ("TINY = 1e-100", "TINY = 1e-101", jobs_after(*STAGES)),
}


@pytest.mark.parametrize("name", list(EDITS))
def test_an_edit_of_the_code_runs_what_uses_it_and_nothing_else(tree, edited, name):
    old, new, expected = EDITS[name]
    edited(name, lambda text: text.replace(old, new, 1))
    assert tree.planned() == expected


def test_dates_do_not_count(tree):
    (tree.place / "src/rockdamp/studies/response_lengths.py").touch()
    assert tree.planned() == {}


def test_a_result_that_was_deleted_is_built_again_alone(tree):
    """What is built then is what was there: test_accidents.py deletes a result and builds it."""
    path = tree.place / RESULTS / "response_lengths.nc"
    path.rename(tree.place / "response_lengths.nc")
    assert tree.planned() == jobs_after("response_lengths")
    (tree.place / "response_lengths.nc").rename(path)


def test_an_edited_record_runs_what_reads_it(tree, edited):
    edited("data/sin-03-00-synthetic.csv", lambda text: text.replace("# ", "# edited: yes\n# ", 1))
    assert tree.planned() == jobs_after("validation", "calibration", "damper_order")

"""What runs again after a change of the config, the code or the data: what depends on it, and nothing else."""

import pytest
from minimal_build import OUTPUTS, RESULTS
from pipeline_graph import jobs_after, readers

from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES
from rockdamp.storage import yaml_file

pytestmark = pytest.mark.workflow

# Keys far apart in the config, and some that read them, by hand; the tables say who else, and what comes after.
CHANGES = {
    "figures: {resolution: 90}": list(FIGURES),
    "validation: {restitution: 0.84}\nearthquakes: {bootstrap: {replicates: 60}}": [
        "validation",
        "accuracy",
        "comparison",
    ],
    "studies: {cracked_stiffness: {yield_displacement_ratio: [0.02, 0.05, 0.17]}}\n"  # one a1
    "population: {bootstrap: {replicates: 30}}": [
        "decay/cracked_stiffness",
        "match/cracked_stiffness",
        "accuracy",
        "population",
    ],
    "matching: {response_length: 9}": [
        "match/amplitude",
        "damping_force",
        "amplitude_dependence",
        "pulses",
        "earthquakes/walls",
        "accuracy",
    ],
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


RECORD = "data/sin-03-00-synthetic.csv"
EDITS = {  # of one file or of two: what has to run after both
    (("src/rockdamp/storage/variables.yaml", "common:", "# edited\ncommon:"),): STAGES,  # attributes
    (
        ("src/rockdamp/studies/response_lengths.py", "PAPER_RANGE = (0.80", "PAPER_RANGE = (0.81"),
        ("src/rockdamp/figures/style.py", "coefficient of restitution $e$", "restitution $e$"),
    ): ["response_lengths", *FIGURES],
    ((RECORD, "# ", "# edited: yes\n# "),): ["validation", "calibration", "damper_order"],
}


@pytest.mark.parametrize("edits", EDITS, ids=lambda edits: edits[0][0])
def test_an_edit_runs_what_uses_it_and_nothing_else(tree, edited, edits):
    (tree.place / "src/rockdamp/studies/matches.py").touch()  # dates do not count
    for name, old, new in edits:
        edited(name, lambda text, old=old, new=new: text.replace(old, new, 1))
    assert tree.planned() == jobs_after(*EDITS[edits])

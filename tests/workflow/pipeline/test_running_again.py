"""What runs again after a change of the config, the code or the data: what depends on it, and nothing else."""

import pytest
import yaml
from minimal_build import OUTPUTS, RESULTS
from pipeline_graph import PAGES, jobs_after, readers

from rockdamp.pipeline.tables import FIGURES

# Keys far apart in the config, and some that read them, by hand; the tables say who else, and what comes after.
CHANGES = {
    "figures: {resolution: 90}": list(FIGURES),
    "validation: {fit_yield_displacement_ratios: [0.03]}\ncomparison: {bootstrap: {replicates: 60}}": [
        "validation",
        "comparison",
    ],
    "studies: {cracked_stiffness: {yield_displacement_ratio: [0.02, 0.05, 0.17]}}": [  # one a1
        "decay/cracked_stiffness",
        "match/cracked_stiffness",
    ],
    "matching: {response_length: 9}": [
        "match/amplitude",
        "damping_force",
        "amplitude",
        "order",
        "earthquakes/walls",
    ],
}


@pytest.mark.long
@pytest.mark.parametrize("overlay", CHANGES)
def test_a_change_of_the_config_runs_what_depends_on_it_and_nothing_else(tree, overlay):
    reading = readers(yaml.safe_load(overlay))
    assert set(CHANGES[overlay]) <= set(reading)
    assert tree.planned(overlay) == jobs_after(*reading, "report")  # which shows the config


@pytest.mark.long
def test_a_partial_run_after_a_change_of_the_config_leaves_the_rest(tree):
    before, overlay = tree.digests(RESULTS), "response_lengths: {step: 5}"
    run = tree.snakemake(overlay=overlay)
    assert run.returncode == 0, run.stderr
    after = tree.digests(RESULTS)
    changed = {name for name in after if before.get(name) != after[name]}
    # the claims are judged by the response lengths
    expected = {f"{RESULTS}/{name}" for name in ("response_lengths.nc", "claims.csv", "claims.json", "errata.csv")}
    assert changed & {f"{RESULTS}/{name}" for name in OUTPUTS} == expected
    assert tree.planned(overlay) == {}
    assert tree.snakemake().returncode == 0  # back to the first state, for the other tests
    assert tree.digests(RESULTS) == before


# An edit of each kind in docs/howto/change-and-rerun.md: files with the old and the new text, and what runs first.
EDITS = {
    "a caption": (
        [("src/rockdamp/figures/mechanism.py", "law of rigid bodies. (b)", "law of rigid walls. (b)")],
        ["fig1", "fig2", *PAGES],
    ),
    "what a name means, or its unit": (
        [
            (
                "src/rockdamp/storage/glossary.yaml",
                'long_name: "coefficient of determination"',
                'long_name: "R squared"',
            ),
            (
                "src/rockdamp/storage/glossary.yaml",
                'giannini_masiani: {units: "1"',
                "giannini_masiani: {units: percent",
            ),
        ],
        ["equivalence"],
    ),
    "a text of the report": ([("src/rockdamp/report/report.html.j2", "How to cite", "Citation")], [*PAGES]),
    "words of errors and warnings, docstrings and comments, also of the config": (
        [
            ("src/rockdamp/histories/loads.py", "and the history would take", "and it would take"),
            ("src/rockdamp/plausibility.py", "the wall does not rock", "the wall stays at rest"),
            ("src/rockdamp/mechanics/wall.py", '"""', '"""Edited. '),
            ("config/default.yaml", "\n", "\n# edited\n"),
            ("src/rockdamp/solvers/newmark_kernel.py", "\n\n\n", "\n\n\n# edited\n"),
        ],
        [],
    ),
    "a line of a kernel": (
        [("src/rockdamp/solvers/exact.py", "TOLERANCE = 1e-13", "TOLERANCE = 2e-13")],
        ["earthquake_check"],
    ),
    "a limit of one stage and a label of all figures": (
        [
            ("src/rockdamp/studies/response_lengths.py", "PAPER_RANGE = (0.80", "PAPER_RANGE = (0.81"),
            ("src/rockdamp/figures/style.py", "coefficient of restitution $e$", "restitution $e$"),
        ],
        ["response_lengths", *FIGURES],
    ),
    "a record": (
        [("data/sin-03-00-synthetic.csv", "# ", "# edited: yes\n# ")],
        ["validation", "calibration"],
    ),
}


@pytest.mark.parametrize("kind", EDITS)
def test_an_edit_runs_what_uses_it_and_nothing_else(tree, edited, kind):
    edits, first = EDITS[kind]
    (tree.place / "src/rockdamp/studies/matches.py").touch()  # dates do not count
    for name, old, new in edits:
        text = (tree.place / name).read_text(encoding="utf-8")
        assert old in text, (name, old)
        edited(name, lambda _, text=text, old=old, new=new: text.replace(old, new, 1))
    assert tree.planned() == jobs_after(*first)

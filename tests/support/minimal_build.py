"""The minimal build, which the tests of figures, claims, report and documents read.

They take the fixture `minimal`. It runs `snakemake --configfile config/minimal.yaml` in the
repository, which builds what is missing or out of date under results/minimal, in about two minutes,
and is shared by all tests of a run. To run some of them on a build as it is, without Snakemake::

    ROCKDAMP_FINISHED_BUILD=results/minimal python -m pytest tests/figures tests/claims tests/report

Tests of the numbers in documents, errata and sensitivities read the full build in results/, by
`pages.read_full`, and are skipped without it.
"""

from rockdamp.constants import STUDIES
from rockdamp.figures import FIGURES

FINISHED_BUILD = "ROCKDAMP_FINISHED_BUILD"  # environment variable: the folder of a finished build
RESULTS = "results/minimal"
LOGS = "logs/results/minimal"
# The kind that the glossary calls each dataset.
KINDS = {
    **{f"decay/{study}": "decay" for study in STUDIES},
    **{f"match/{study}": "match" for study in STUDIES},
    "mechanism": "mechanism",
    "damping_force": "damping_force",
    "response_lengths": "response_lengths",
    "equivalence": "equivalence",
    "calibration": "calibration",
    "validation": "validation",
    "bilinear": "bilinear",
    "measured_rocking": "measured_rocking",
    "convergence": "convergence",
    "amplitude": "amplitude",
    "earthquakes": "earthquakes",
    "earthquakes/walls": "earthquake_walls",
    "earthquakes/check": "earthquake_check",
    "comparison": "comparison",
    "order": "order",
    "loss_law": "loss_law",
    "supports": "supports",
}
# Parts of the last stages, one for each job.
PARTS = {
    "earthquakes/records-0": "earthquake_records",
    "earthquakes/records-1": "earthquake_records",
    "earthquakes/order-0": "order_records",
    "earthquakes/order-1": "order_records",
}
DATASETS = [f"{name}.nc" for name in KINDS]
PART_FILES = [f"{name}.nc" for name in PARTS]
FIGURE_FILES = [f"figures/{name}.{suffix}" for name in FIGURES for suffix in ("pdf", "png")]
OUTPUTS = [
    *DATASETS,
    "coefficients.csv",
    "claims.csv",
    "report.html",
    "paper.html",
    *FIGURE_FILES,
]

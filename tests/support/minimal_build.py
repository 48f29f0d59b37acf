"""The minimal build, which the tests of figures, claims, report and documents read.

They take the fixture `minimal`. It runs `snakemake --configfile config/minimal.yaml` in the repository,
which builds what is missing or out of date under results/minimal, in about two minutes, and is shared
by all tests of a run. To run some of them on a build as it is, without Snakemake::

    ROCKDAMP_FINISHED_BUILD=results/minimal python -m pytest tests/figures tests/claims tests/report
"""

from rockdamp.constants import STUDIES
from rockdamp.figures import FIGURES

FINISHED_BUILD = "ROCKDAMP_FINISHED_BUILD"  # environment variable: the folder of a finished build
RESULTS = "results/minimal"
LOGS = "logs/results/minimal"
DECAYS, MATCHES = ([f"{kind}/{study}" for study in STUDIES] for kind in ("decay", "match"))
# What the glossary calls each dataset that the report shows.
KINDS = {
    **dict.fromkeys(MATCHES, "match"),
    **{
        name: name
        for name in ("mechanism", "damping_force", "response_lengths", "equivalence", "calibration")
    },
    **{
        name: name
        for name in ("validation", "bilinear", "measured_rocking", "convergence", "amplitude")
    },
    **{name: name for name in ("earthquakes", "comparison", "order", "loss_law", "supports")},
    "earthquakes/walls": "earthquake_walls",
    "earthquakes/check": "earthquake_check",
}
DATASETS = [f"{name}.nc" for name in (*DECAYS, *KINDS)]
OUTPUTS = [
    *DATASETS,
    *("coefficients.csv", "claims.csv", "report.html", "paper.html"),
    *(f"figures/{name}.{suffix}" for name in FIGURES for suffix in ("pdf", "png")),
]
PAPER_FIGURES = [name for name in FIGURES if not name.startswith("fig_")]

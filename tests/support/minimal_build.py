"""What a build of the minimal config leaves."""

from rockdamp.constants import STUDIES
from rockdamp.figures import FIGURES

RESULTS, LOGS = "results/minimal", "logs/results/minimal"
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

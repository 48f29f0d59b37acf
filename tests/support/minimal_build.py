"""What a build of the minimal config leaves, by the tables of stages and figures."""

from rockdamp.pipeline.figures import FIGURES
from rockdamp.pipeline.stages import STAGES, each_study

RESULTS = "results/minimal"
WHOLE = [stage for stage in STAGES.values() if "{share}" not in stage.file]
DATASETS = [f"{name}.nc" for stage in WHOLE if stage.dataset for name in each_study(stage.dataset)]
OUTPUTS = [
    *DATASETS,
    *(stage.file for stage in WHOLE if not stage.dataset),
    "errata.csv",
    *(f"figures/{name}.{suffix}" for name in FIGURES for suffix in ("pdf", "png")),
]

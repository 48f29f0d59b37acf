"""Files that a build of the minimal config leaves, by the tables of stages and figures."""

from rockdamp.pipeline.tables import FIGURES, STAGES, each_study

RESULTS, LOGS = "results/minimal", "logs/results/minimal"
WHOLE = [stage for stage in STAGES.values() if "{chunk}" not in stage.file]
DATASETS = [f"{name}.nc" for stage in WHOLE if stage.dataset for name in each_study(stage.dataset)]
OUTPUTS = [
    *DATASETS,
    *(file for stage in WHOLE if not stage.dataset for file in (stage.file, *stage.also)),
    *(f"figures/{name}.{suffix}" for name in FIGURES for suffix in ("pdf", "png")),
]

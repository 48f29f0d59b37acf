"""rockdamp: every dataset and figure of the paper, from a wall to Fig. 8. The config says with which values."""

import os
import re
import time
from operator import attrgetter
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from rockdamp.motions import catalogue

from rockdamp.config import parse_config
from rockdamp.errors import InputError
from rockdamp.pipeline.origins import origins
from rockdamp.pipeline.tables import REPORT, built, drawn, each_study, reported
from rockdamp.storage.atomic import tidy
from rockdamp.vocabulary import STUDIES

min_version("9.8")


configfile: "config/default.yaml"


try:
    CONFIG = parse_config(config)
except InputError as error:
    raise WorkflowError(str(error)) from None

# A bare `snakemake` does not pass through make, so the jobs' environment is set here. Dates in PDF and SVG are fixed.
os.environ.setdefault("SOURCE_DATE_EPOCH", "1577836800")
# A job compares its sources with their version only if one was edited since now.
os.environ.setdefault("ROCKDAMP_RUN_BEGAN", str(time.time()))
# On several threads BLAS adds in another order: the last bits of a matrix product would depend on the number of cores.
os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")


include: "workflow/rules/common.smk"


onstart:
    for folder in {os.path.dirname(file) for file in RESULT_FILES}:  # those of this config alone
        tidy(Path(RESULTS, folder))
    # Numba compiles the solvers here, once: jobs that start together would all compile them, into the same files.
    from rockdamp.pipeline.compile_all import compile_all

    # A run on a cluster has no number of cores, and `workflow.cores` raises there.
    compile_all(workflow.resource_settings.cores or 1)


include: "workflow/rules/stages.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"


localrules:
    all,


rule all:
    default_target: True
    input:
        [f"{RESULTS}/{file}" for file in RESULT_FILES],
    message:
        "Every dataset, every figure and the report are up to date"


# `snakemake --list` shows the docstring of a rule. The rules that loops make have theirs from the tables.
for each in workflow.rules:
    each.docstring = each.message.replace("{wildcards.", "{")

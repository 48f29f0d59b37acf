"""rockdamp: every dataset, figure and page, from a wall to the report, with the config's values."""

import os
import shlex
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from rockdamp.config.rules import find_file, parse_config
from rockdamp.errors import InputError
from rockdamp.motions.catalogue import record_names

min_version("9.27")


PROJECT = Path(workflow.current_basedir)


configfile: PROJECT / "config/default.yaml"


if shlex.quote(sys.executable) != sys.executable:
    raise WorkflowError(
        f"Snakemake cannot start jobs with {sys.executable!r}:"
        " move the project to a folder whose path has no blanks or quotes, and set it up there"
    )

try:
    CONFIG = parse_config(config, PROJECT)
    RECORDS = record_names(CONFIG.records)
    BILINEAR_RECORDS = record_names(CONFIG.bilinear.records)
except InputError as error:
    raise WorkflowError(str(error)) from None

# Results have the same bytes at any number of cores and on any day: BLAS on several threads would
# add in another order, and a PDF would state its date. The date is 1 January 2020.
THREADS = ("NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS")
os.environ |= dict.fromkeys(THREADS, "1")
os.environ.setdefault("SOURCE_DATE_EPOCH", "1577836800")


include: "workflow/rules/common.smk"
include: "workflow/rules/paper.smk"
include: "workflow/rules/beyond.smk"
include: "workflow/rules/earthquakes.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"


onstart:
    # Jobs that start together would each compile the solvers, into the same files of Numba's cache.
    from rockdamp.solvers.compile_all import compile_all

    compile_all()


localrules:
    all,
    paper,
    decay,
    match,
    earthquakes,


rule paper:
    input:
        "<results>/paper.html",
        "<results>/claims.csv",
        "<results>/coefficients.csv",
        rules.decay.input,
        rules.claims.input.datasets,
        PAPER_FIGURE_FILES,


rule all:
    default_target: True
    input:
        rules.paper.input,
        rules.earthquakes.input,
        rules.report.input.datasets,
        rules.report.output,
        FIGURE_FILES,

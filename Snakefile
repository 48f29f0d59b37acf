"""rockdamp: every dataset, figure and page, from a wall to the report. The config says with which values."""

import os

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from rockdamp.config import parse_config
from rockdamp.errors import InputError

min_version("9.27")


configfile: "config/default.yaml"


try:
    CONFIG = parse_config(config)
except InputError as error:
    raise WorkflowError(str(error)) from None

# The same bytes at any number of cores: on several threads BLAS adds in another order, and PDF states its date.
os.environ |= dict.fromkeys(
    ["NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"], "1"
)
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
        PAPER_FIGURE_FILES,


rule all:
    default_target: True
    input:
        rules.paper.input,
        rules.earthquakes.input,
        rules.report.output,
        FIGURE_FILES,

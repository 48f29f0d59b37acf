"""rockdamp: every dataset and figure of the paper, from a wall to Fig. 8. The config says with which values."""

import os
import sys
import time
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from rockdamp.arguments import check_environment
from rockdamp.motions import catalogue

from rockdamp.pipeline import verification
from rockdamp.pipeline.figures import FIGURES, REPORT
from rockdamp.pipeline.stages import STAGES, reported
from rockdamp.config.results_folder import require_folders, require_own_folder, require_writable
from rockdamp.errors import InputError, warnings_as_lines
from rockdamp.storage.atomic import tidy
from rockdamp.storage.dotted_keys import stated
from rockdamp.storage.provenance import subset
from rockdamp.vocabulary import STUDIES

min_version("9.8")


configfile: "config/default.yaml"


# Bad input ends the run here, before anything is built or deleted; once, and not for every job.
if workflow.is_main_process:
    from rockdamp.config.merging import refuse_other_readings
    from rockdamp.config.schema import refuse_old_targets
    from rockdamp.config.validation import require_readable_motions, validate
    from rockdamp.laboratory.trials import require_readable_trials

    try:
        check_environment()
        files = ["config/default.yaml", *map(os.path.relpath, workflow.overwrite_configfiles)]
        files = files[workflow.config_settings.replace_workflow_config :]
        refuse_old_targets(sys.argv[1:])  # Snakemake has not parsed its targets yet
        refuse_other_readings(config, files, workflow.config_settings.config)
        with warnings_as_lines():
            validate(config, Path(workflow.basedir, "workflow/schemas/config.schema.yaml"), files)
            require_readable_motions(config)
            require_readable_trials(config)
        require_own_folder(config["results"], tree=workflow.basedir)
    except InputError as error:
        raise WorkflowError(str(error)) from None

# A bare `snakemake` does not pass through make, so the jobs' environment is set here. Dates in PDF and SVG are fixed.
os.environ.setdefault("SOURCE_DATE_EPOCH", "1577836800")
# A job compares its sources with their version only if one was edited since now.
os.environ.setdefault("ROCKDAMP_RUN_BEGAN", str(time.time()))
# On several threads BLAS adds in another order: the last bits of a matrix product would depend on the number of cores.
os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")


include: "workflow/rules/common.smk"


# Snakemake would end in a traceback on a file where a folder must be.
if workflow.is_main_process:
    subfolders = {os.path.dirname(file) for file in ORIGINS}
    try:
        require_folders(RESULTS, subfolders, "the results")
        require_folders(LOGS, subfolders, "the logs")
    except InputError as error:
        raise WorkflowError(str(error)) from None


onstart:
    try:
        require_writable(RESULTS, "the results")
        require_writable(LOGS, "the logs")
    except InputError as error:
        raise WorkflowError(str(error)) from None
    for folder in subfolders:  # of this config; in folders of others another run may be at work
        tidy(Path(RESULTS, folder))
    # Numba compiles the solvers here, once: jobs that start together would all compile them, into the same files.
    from rockdamp.solvers import compile_all

    # A run on a cluster has no number of cores, and `workflow.cores` raises there.
    compile_all(workflow.resource_settings.cores or 1)


include: "workflow/rules/stages.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/dictionary.smk"
include: "workflow/rules/checksums.smk"


localrules:
    all,


rule all:
    default_target: True
    input:
        rules.checksums.input.results,
        rules.checksums.output,
    message:
        "Every dataset, every figure and the report are up to date"


# `snakemake --list` shows the docstring of a rule. The rules that loops make have theirs from the tables.
for each in workflow.rules:
    each.docstring = each.message.replace("{wildcards.", "{")

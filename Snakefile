"""rockdamp: every dataset and figure of the paper, from a wall to Fig. 8. The config says with which values."""

import os
import re
import time
from operator import attrgetter
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from rockdamp.arguments import check_environment
from rockdamp.motions import catalogue

from rockdamp.config.checks import require_readable_motions, validate
from rockdamp.config.files import merged, refuse_braces, require_folders, require_own_folder, require_writable
from rockdamp.errors import InputError, warnings_as_lines
from rockdamp.laboratory.named_tests import require_possible_tests
from rockdamp.laboratory.sections import LaboratoryConfig, broken
from rockdamp.laboratory.trials import read_rocking_trials
from rockdamp.pipeline.origins import origins
from rockdamp.pipeline.tables import REPORT, built, drawn, each_study, reported, values_of
from rockdamp.storage.atomic import tidy
from rockdamp.vocabulary import STUDIES

min_version("9.8")


configfile: "config/default.yaml"


# The files are read anew, by YAML 1.2: Snakemake's reading takes 1e-3 for a text and 010 for 8.
FILES = ["config/default.yaml", *map(os.path.relpath, workflow.overwrite_configfiles)]
FILES = FILES[workflow.config_settings.replace_workflow_config :]
given = merged(FILES, workflow.config_settings.config)
config.clear()
config.update(given)

# Bad input ends the run here, before anything is built or deleted; once, and not for every job.
if workflow.is_main_process:
    try:
        check_environment()
        with warnings_as_lines():
            CONFIG = validate(LaboratoryConfig, config, FILES, [broken])
            built_here = built(CONFIG).values()
            tests = values_of(CONFIG, built_here, "records")
            require_readable_motions(tests, values_of(CONFIG, built_here, "motions"))
            require_possible_tests(tests, CONFIG.validation.wall)
            for path in values_of(CONFIG, built_here, "trials"):
                refuse_braces([path])
                read_rocking_trials(path)
        require_own_folder(CONFIG.results, tree=workflow.basedir)
    except InputError as error:
        raise WorkflowError(str(error)) from None
else:
    CONFIG = LaboratoryConfig.model_validate(config)

# A bare `snakemake` does not pass through make, so the jobs' environment is set here. Dates in PDF and SVG are fixed.
os.environ.setdefault("SOURCE_DATE_EPOCH", "1577836800")
# A job compares its sources with their version only if one was edited since now.
os.environ.setdefault("ROCKDAMP_RUN_BEGAN", str(time.time()))
# On several threads BLAS adds in another order: the last bits of a matrix product would depend on the number of cores.
os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")


include: "workflow/rules/common.smk"


# Snakemake would end in a traceback on a file where a folder must be.
if workflow.is_main_process:
    subfolders = {os.path.dirname(file) for file in RESULT_FILES}
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

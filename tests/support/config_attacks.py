"""Configs with something odd at some keys, and texts of configs with bytes changed."""

from __future__ import annotations

import copy
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from attacks import ANSWER, REFUSED, Attack
from record_attacks import BYTES
from repository import ROOT
from snakemake.utils import update_config

import rockdamp as rd
from rockdamp.config import merging, validation
from rockdamp.config.schema import schema_problems
from rockdamp.storage import yaml_file

SCHEMA = ROOT / "workflow/schemas/config.schema.yaml"
ODD: list[Any] = [None, True, 0, -1, 0.5, 1e-320, 1e308, 10**30, float("nan"), "", "1e-3", "x", [], {}, [[]], {"a": 1}]
ODD += [[0.5, 0.5], [0.9, 0.1], "\x1b[31m", "../..", "/", "$HOME", "a\nb", "١"]


def config_attacks(seed: int) -> Iterator[Attack]:
    """Yield configs with something odd at one to three keys, and texts of configs with bytes changed."""
    rng = random.Random(seed)
    whole: dict[str, Any] = {}
    for name in ("default", "minimal"):
        update_config(whole, yaml_file.load((ROOT / f"config/{name}.yaml").read_text(encoding="utf-8")))
    rules, places = validation.read_schema(SCHEMA), sorted(_places(whole), key=str)
    text = (ROOT / "config/minimal.yaml").read_bytes()
    while True:
        if rng.random() < 0.3:
            yield Attack("config:text", _config_text(rng, text))
            continue
        config = copy.deepcopy(whole)
        for place in rng.sample(places, rng.choice((1, 1, 2, 3))):
            _put(config, place, rng.choice(ODD))
        yield Attack("config:value", _config_judge(config, rules))


def _places(value: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    if path:
        yield path
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, item in items:
        yield from _places(item, (*path, key))


def _put(config: Any, place: tuple[Any, ...], value: Any) -> None:
    for key in place[:-1]:
        there = config if isinstance(config, dict) else range(len(config)) if isinstance(config, list) else ()
        if key not in there:  # another attack was there first
            return
        config = config[key]
    if isinstance(config, dict) or (isinstance(config, list) and place[-1] in range(len(config))):
        config[place[-1]] = value


def _config_judge(config: dict[str, Any], rules: Any) -> Callable[[Path], str]:
    def run(_: Path) -> str:
        found = schema_problems(config, rules) or validation.problems(config)
        if not found:
            return ANSWER
        return REFUSED if all(len(str(line).splitlines()) == 1 for line in found) else "a refusal of several lines"

    return run


def _config_text(rng: random.Random, text: bytes) -> Callable[[Path], str]:
    for _ in range(rng.randrange(1, 4)):
        at = rng.randrange(len(text))
        text = (
            text[:at]
            + rng.choice([*BYTES, b"&a", b"*a", b"!!python/name:os", b"{", b"- "])
            + text[at + rng.randrange(3) :]
        )

    def run(folder: Path) -> str:
        path = folder / "config.yaml"
        path.write_bytes(text)
        try:
            read = merging.merged([path], {})
        except rd.InputError as error:
            return REFUSED if "config.yaml" in str(error) else f"refused without the file's name: {error}"
        return ANSWER if isinstance(read, dict) else f"a config that is a {type(read).__name__}"

    return run

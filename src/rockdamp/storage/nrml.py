"""Write fragility in NRML 0.5, the format that OpenQuake reads: functions of collapse, continuous and discrete."""

from __future__ import annotations

import math
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.resources import files

import numpy as np
from jinja2 import Environment, StrictUndefined

from rockdamp.errors import InputError, printable, require
from rockdamp.plausibility import warn
from rockdamp.storage.atomic import replacing
from rockdamp.vocabulary import STANDARD_GRAVITY

NAMESPACE = "http://openquake.org/xmlns/nrml/0.5"
# OpenQuake's units of the intensity measures: PGA in g, PGV in cm/s; what SI is multiplied by.
UNITS: Mapping[str, tuple[str, float]] = {"PGA": ("g", 1 / STANDARD_GRAVITY), "PGV": ("cm/s", 100.0)}
LIMIT_STATE = "collapse"
RISING = "finite, at least 0 and rising"


@dataclass(frozen=True)
class Collapse:
    """The fragility of one wall, or of a population: a lognormal function, and the share of collapses at each stripe.

    The name is the functions' taxonomy, as typed but for white space, which OpenQuake's reader refuses. Their ids have
    an underscore for what NRML's ids do not take.
    Median and intensity are in m s-1 or m s-2; median and dispersion are NaN where the function is not defined.
    """

    name: str
    median: float
    dispersion: float
    intensity: Sequence[float]
    share: Sequence[float]


def text(collapses: Iterable[Collapse], measure: str, name: str, description: str) -> str:
    """Return a fragility model: of each collapse a continuous function and, with ``-discrete``, its stripes.

    A collapse without a lognormal function has the stripes alone. White space in a taxonomy becomes an underscore,
    with a warning. `measure` is one of `UNITS`. What is no fragility raises `InputError`: no function at all, shares
    outside of 0 to 1, intensities below 0 or that do not rise, a median or a dispersion that is not greater than 0.
    """
    unit, factor = UNITS[measure]
    collapses = list(collapses)
    require(len(collapses) > 0, "the number of fragilities", len(collapses), "at least 1")
    # A name that is an identifier as it was typed keeps it, whatever others become.
    taken: set[str] = set()
    typed = {collapse.name for collapse in collapses if _identifier(collapse.name) == collapse.name}
    functions = []
    for collapse in collapses:
        _check(collapse)
        identifier = _identifier(collapse.name)
        while identifier in taken or (identifier in typed and identifier != collapse.name):
            identifier += "_"
        taken |= {identifier, f"{identifier}-discrete"}
        # NRML states mean and standard deviation of the intensity at collapse, not of its logarithm.
        mean = factor * collapse.median * math.exp(collapse.dispersion**2 / 2)
        deviation = mean * math.sqrt(math.expm1(collapse.dispersion**2))
        levels = [factor * float(level) for level in collapse.intensity]
        taxonomy = re.sub(r"\s", "_", printable(collapse.name))
        functions.append(
            (identifier, taxonomy, levels, list(map(float, collapse.share)), float(mean), float(deviation))
        )
    spaced = [collapse.name for collapse in collapses if re.search(r"\s", collapse.name)]
    if spaced:
        warn([f"white space in taxonomies, as in {spaced[0]!r}, is written as _: OpenQuake does not read it"])
    template = files("rockdamp.storage").joinpath("nrml.xml.j2").read_text(encoding="utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    return environment.from_string(template, {"namespace": NAMESPACE, "limit_state": LIMIT_STATE}).render(
        name=_identifier(name), description=f"{description} {measure} in {unit}.", measure=measure, functions=functions
    )


def _check(collapse: Collapse) -> None:
    """Raise `InputError` for what is no fragility: a reader of NRML would not notice."""
    name, levels, share = collapse.name, np.asarray(collapse.intensity), np.asarray(collapse.share)
    if levels.size == 0 or levels.shape != share.shape:
        raise InputError(f"{name!r} has {levels.size} intensities and {share.size} shares; it must have one for each")
    rises = (np.diff(levels, prepend=-1.0) > 0) & (levels >= 0) & np.isfinite(levels)
    require(rises, f"intensity of {name!r}", levels, RISING)
    require((share >= 0) & (share <= 1), f"share of collapses of {name!r}", share, "between 0 and 1")
    if not (math.isnan(collapse.median) and math.isnan(collapse.dispersion)):
        for quantity, value in (("median", collapse.median), ("dispersion", collapse.dispersion)):
            require(0 < value < math.inf, f"{quantity} of {name!r}", value, "greater than 0, or NaN in both")


def write(path: str | os.PathLike[str], content: str) -> None:
    """Write what `text` returned, complete or not at all."""
    with replacing(path) as temporary:
        temporary.write_text(content, encoding="utf-8", newline="\n")


def _identifier(name: str) -> str:
    """Return a name with what NRML's ids do not take written as an underscore."""
    return "".join(letter if letter.isascii() and (letter.isalnum() or letter in "-_.") else "_" for letter in name)

"""Captions of the figures. The words are in the table of figures; every number is computed here, from datasets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from jinja2 import Environment, StrictUndefined
from markupsafe import Markup

from rockdamp.pipeline.figures import FIGURES
from rockdamp.report import earthquake_captions, further_captions, paper_captions
from rockdamp.storage.dataset import Datasets


class Caption(NamedTuple):
    """What stands with a figure; the caption and the alternative text are HTML."""

    title: str
    alternative: str
    text: str


# A figure's numbers are a function of its name in one of these; a caption without numbers has none.
NUMBERS: dict[str, Callable[[Datasets], dict[str, Any]]] = {
    name: getattr(module, name)
    for module in (paper_captions, further_captions, earthquake_captions)
    for name in FIGURES
    if hasattr(module, name)
}


def caption(name: str, data: Datasets) -> Caption:
    """Fill a figure's caption with the numbers of its datasets.

    Raises
    ------
    KeyError
        If there is no such figure, or a dataset that its numbers need is not given.
    """
    environment = Environment(autoescape=True, undefined=StrictUndefined, trim_blocks=True)
    figure, values = FIGURES[name], NUMBERS[name](data) if name in NUMBERS else {}
    words = (figure.title, figure.alternative, figure.caption)
    parts = [environment.from_string(text).render(values).strip() for text in words]
    return Caption(parts[0], Markup(parts[1]).striptags(), Markup(parts[2]))

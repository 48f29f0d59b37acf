"""The parts of the report that are read from files: tables of claims and errata, prose, citation and versions."""

from __future__ import annotations

import csv
import os
import platform
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

import yaml
from markdown_it import MarkdownIt
from markdown_it.token import Token
from markupsafe import Markup, escape

from rockdamp.claims import FAILS, HOLDS, IN_PART, UNTESTED

# How each verdict is marked, by shape and word as well as colour.
MARKS = {FAILS: ("no", "✗"), IN_PART: ("partly", "◐"), UNTESTED: ("unknown", "–"), HOLDS: ("yes", "✓")}
SOFTWARE = ("rockdamp", "numpy", "scipy", "numba", "xarray", "netCDF4", "matplotlib", "snakemake")


def rows(path: str | os.PathLike[str]) -> list[dict[str, str]]:
    """Read a table that the pipeline wrote."""
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file, strict=True))


def judged(claims: Sequence[Mapping[str, str]]) -> list[dict[str, Any]]:
    """Return the verdicts, each with its mark and its claims, what fails first."""
    return [
        {"verdict": name, "kind": kind, "mark": mark, "claims": [claim for claim in claims if claim["verdict"] == name]}
        for name, (kind, mark) in MARKS.items()
    ]


def inline(text: str) -> Markup:
    """Return a cell's text as HTML: what stands between backticks as code, u_ins with its index, minus as a minus."""
    html = re.sub(r"`([^`]+)`", r"<code>\1</code>", str(escape(text)))
    html = re.sub(r"(?<![\w])-(?=\d)", "−", html)
    html = re.sub(r"(?<=\d)%", "&nbsp;%", html)
    return Markup(html.replace("u_ins", "u<sub>ins</sub>"))


def prose(markdown: str) -> str:
    """Return a document as HTML for a section: headings a level lower, no title, comments and links into the tree."""
    without_comments = re.sub(r"<!--.*?-->", "", markdown, flags=re.DOTALL)
    tokens = MarkdownIt("commonmark", {"html": False}).enable("table").parse(without_comments)
    kept: list[Token] = []
    skipping = False
    for token in tokens:
        if token.type in ("heading_open", "heading_close"):
            if token.tag == "h1":
                skipping = token.type == "heading_open"
                continue
            token.tag = f"h{min(int(token.tag[1]) + 1, 6)}"
        if skipping:
            continue
        if token.children:
            token.children = _without_links_inside(token.children)
        kept.append(token)
    html = str(MarkdownIt("commonmark").enable("table").renderer.render(kept, MarkdownIt().options, {}))
    return html.replace("<table>", '<div class="scroll" tabindex="0"><table>').replace("</table>", "</table></div>")


def _without_links_inside(tokens: Sequence[Token]) -> list[Token]:
    """Remove images from the tokens of a line, and links to other files, whose text stays."""
    kept, dropped = [], []
    for token in tokens:
        if token.type == "image":
            continue
        if token.type == "link_open":
            dropped.append(not str(token.attrGet("href")).startswith(("https://", "http://")))
            if dropped[-1]:
                continue
        elif token.type == "link_close" and dropped.pop():
            continue
        kept.append(token)
    return kept


def citation(text: str) -> dict[str, str]:
    """Return what a citation file says, as one reference and as BibTeX, and the work that it refers to."""
    cff = yaml.safe_load(text)
    names = [_name(author) for author in cff["authors"]]
    where = cff.get("doi") or cff.get("url") or cff.get("repository-code") or ""
    kind = "Computer software"
    parts = [f"{', '.join(names)}. {cff['title']} (version {cff['version']}) [{kind}]. {cff['license']}.", where]
    lines = {
        "author": " and ".join(f"{{{name}}}" for name in names),
        "title": f"{{{cff['title']}}}",
        "version": cff["version"],
        "note": kind,
    }
    body = ",\n".join(f"  {key} = {{{value}}}" for key, value in lines.items())
    return {
        "message": str(cff["message"]),
        "reference": " ".join(part for part in parts if part),
        "bibtex": f"@misc{{rockdamp,\n{body}\n}}",
        "paper": "; ".join(str(work["title"]) for work in cff.get("references", ())),
    }


def _name(author: Mapping[str, str]) -> str:
    return author.get("name") or f"{author.get('family-names', '')}, {author.get('given-names', '')}".strip(", ")


def software() -> list[tuple[str, str]]:
    """Return the versions of Python and of what the results stand on."""
    return [("Python", platform.python_version()), *((name, version(name)) for name in SOFTWARE)]

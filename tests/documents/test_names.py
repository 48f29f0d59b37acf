"""The documents name what is there: modules, files, folders, make targets; and the site keeps every line of them."""

import re
import sys
import tomllib
from functools import cache
from pathlib import Path
from pkgutil import resolve_name

import pytest
from repository import ROOT

PAGES = [
    str(path.relative_to(ROOT))
    for path in sorted(
        (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), ROOT / "data/README.md", ROOT / "data/sources.csv")
    )
]
# Pages that add something name what their readers make, and are executed; the changelog names what was renamed.
OF_THE_TREE = [page for page in PAGES if "/add-a-" not in page and page != "CHANGELOG.md"]
FOLDERS = "src tests tools docs data config workflow profiles examples benchmarks .ci .github".split()
SUFFIXES = tuple(".py .yaml .yml .md .csv .toml .lock .smk .js .rst .json .ipynb .mplstyle".split())
MADE = ("results/", "logs/", "build/", ".venv", ".snakemake/")  # by builds, and what readers make: my-...


@cache
def tree():
    inside = [path for folder in FOLDERS for path in (ROOT / folder).rglob("*")]
    return [f"/{path.relative_to(ROOT)}" for path in (*ROOT.iterdir(), *inside)]


def text(page):
    return (ROOT / page).read_text(encoding="utf-8")


@pytest.mark.parametrize("page", PAGES)
def test_no_line_begins_with_a_percent_sign(page):
    """MyST takes such a line for a comment, and drops it."""
    assert [line for line in text(page).splitlines() if line.lstrip().startswith("%")] == []


@pytest.mark.parametrize("page", OF_THE_TREE)
def test_every_name_of_the_package_exists(page):
    for name in set(re.findall(r"(?<![\w./-])rockdamp(?:\.[a-zA-Z_]\w*)+", text(page))):
        resolve_name(name)


@pytest.mark.parametrize("page", OF_THE_TREE)
def test_every_file_and_folder_exists(page):
    """By its path, or by the end of it where the text has said in which folder it lies."""
    spans = set(re.findall(r"`([\w.-]*[/.][\w./-]*)`", text(page)))
    named = {span for span in spans if "/" in span or span.endswith(SUFFIXES)}
    made = {name for name in named if name.startswith(MADE) or "/my-" in f"/{name}"}
    paths = tree()
    assert [name for name in named - made if not any(path.endswith("/" + name.rstrip("/")) for path in paths)] == []


@pytest.mark.parametrize("page", PAGES)
def test_every_target_of_make_and_every_program_of_the_environment_exists(page):
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE)
    commands = re.findall(r"(?:`|^|&& )make((?: [a-z-]+)*)", text(page), re.MULTILINE)
    assert {name for words in commands for name in words.split()} <= set(targets)
    programs = set(re.findall(r"\.venv/bin/([\w-]+)", text(page)))
    assert [name for name in programs if not Path(sys.executable).with_name(name).exists()] == []


def test_contributing_shows_the_layers_that_the_linter_checks():
    rows = re.findall(r"^\| (`.*?) \|", text("CONTRIBUTING.md"), re.MULTILINE)
    contract = tomllib.loads(text("pyproject.toml"))["tool"]["importlinter"]["contracts"][0]
    assert [re.findall(r"\w+", row) for row in rows] == [re.findall(r"\w+", layer) for layer in contract["layers"]]


def test_the_pages_are_found():
    assert {"README.md", "docs/theory.md", "docs/howto/your-wall.md", "data/README.md"} <= set(OF_THE_TREE)

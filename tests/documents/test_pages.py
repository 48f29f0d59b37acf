"""Every page of the documents: its commands and its Python run, print what they show, and name what
is there.
"""

import re
from pkgutil import resolve_name

import pytest
from page_blocks import FULL, PAGES, link_results, make_tree, read, reads_results, run_page
from repository import ROOT

LONG = ("docs/reproduce.md", "docs/extend.md")
LONG += tuple(
    f"docs/howto/{name}.md" for name in ("one-wall", "floors", "free-rocking-test", "records")
)
FOLDERS = (
    "src/rockdamp",
    "tests",
    "tools",
    "data",
    "config",
    "workflow",
    "profiles",
    "examples",
    "benchmarks",
    ".ci",
)
FILE = re.compile(r"`((?:[\w.-]+/)+(?:[\w.-]+\.\w+)?)`")
MADE = ("results/", "logs/", "build/", "my-")  # by builds, and by the reader


def mark(page):
    return pytest.param(page, marks=pytest.mark.long if page in LONG else ())


@pytest.mark.parametrize("page", [mark(page) for page in PAGES])
def test_commands_and_python_of_a_page(page, tmp_path, request):
    tree = make_tree(tmp_path / "tree")
    if reads_results(page):
        link_results(tree, ROOT / "results" if FULL else request.getfixturevalue("minimal"))
    run_page(tree, page)
    if reads_results(page) and not FULL:
        pytest.skip("it runs, but no full build is there to compare its numbers with")


@pytest.mark.parametrize("page", PAGES)
def test_files_modules_and_targets_exist(page):
    text = read(page)
    for name in set(re.findall(r"(?<![\w./-])rockdamp(?:\.[a-zA-Z_]\w*)+", text)):
        resolve_name(name)
    made = set(re.findall(r"^# ([\w./-]+\.\w+)$", text, re.MULTILINE))
    roots = [ROOT, *(ROOT / folder for folder in FOLDERS)]
    for name in set(FILE.findall(text)) - made:
        assert name.startswith(MADE) or any((root / name).exists() for root in roots), name
    for name in re.findall(r"\]\(([^)#:]+?)(?:#[\w-]+)?\)", text):
        assert (ROOT / page).parent.joinpath(name).exists(), name
    targets = re.findall(
        r"^([a-z-]+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE
    )
    assert set(re.findall(r"(?:`|^)make ([a-z-]+)", text, re.MULTILINE)) <= set(targets)

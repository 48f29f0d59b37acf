"""The documents name what is there: modules, files and folders of the tree; and the site keeps every line of them."""

import re
from pkgutil import resolve_name

import pytest
from repository import ROOT

PAGES = [
    str(path.relative_to(ROOT))
    for path in sorted(
        (*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), ROOT / "data/README.md", ROOT / "data/sources.csv")
    )
]
OF_THE_TREE = [page for page in PAGES if "/add-a-" not in page]  # those name what their readers make, and are executed
FOLDERS = "src|tests|tools|docs|data|config|workflow|profiles|examples|benchmarks"


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
def test_every_file_and_folder_of_the_tree_exists(page):
    named = set(re.findall(rf"`((?:{FOLDERS})/[\w./-]+)`", text(page)))
    assert [name for name in named if not (ROOT / name).exists()] == []


def test_the_pages_are_found():
    assert {"README.md", "docs/theory.md", "docs/howto/your-wall.md", "data/README.md"} <= set(OF_THE_TREE)

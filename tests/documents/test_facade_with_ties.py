"""The how-to of a facade with ties, word by word."""

import re

import numpy as np
import pytest
from howto_pages import blocks, follow, make_tree
from html_page import Page, words
from repository import ROOT

PAGE = (ROOT / "docs/howto/facade-with-ties.md").read_text(encoding="utf-8")
PER_CENT = re.compile(r"(\d+)%")


@pytest.fixture(scope="module")
def tree(tmp_path_factory):
    return make_tree(tmp_path_factory.mktemp("ties") / "tree")


def test_the_front_has_the_probabilities_that_the_page_shows(tree):
    printed = follow(tree, "facade-with-ties")
    with_, needed = blocks("facade-with-ties", "text")
    for line in ("without the ties: probability of collapse", "probability of collapse at 0.35 g:"):
        said, found = (float(PER_CENT.search(text[text.index(line) :])[1]) for text in (with_, printed))
        assert found == pytest.approx(said, abs=3)
    stretch = re.compile(r"stretched by up to (\d+) mm; they never break")
    assert float(stretch.search(printed)[1]) == pytest.approx(float(stretch.search(with_)[1]), rel=0.3)
    assert (tree.place / "front.png").is_file() and (tree.place / "history.png").is_file()
    page = Page((tree.place / "front.html").read_text(encoding="utf-8"))
    shown = words(page.all("body")[0]["text"].replace("\xa0", " "))
    without = float(PER_CENT.search(printed[printed.index("without the ties:") :])[1])
    assert f"Without its ties: {without:g} %" in shown and "of 44 histories collapse this facade" in shown
    assert "How good it is" in shown and "the ties are stretched by" in shown
    assert [image["attrs"]["src"][:22] for image in page.all("img")] == ["data:image/png;base64,"] * 3
    # Of ties that never break, and of those that break at a stretch.
    said, found = (
        re.findall(r"ties of ([\d.]+) kN in all.* leave (\d+)%.* up to (\d+) mm", text) for text in (needed, printed)
    )
    assert len(said) == 2
    # Largest peaks of survivors and shares of 44 histories fork from one processor to another.
    apart = np.abs(np.array(found, float) - np.array(said, float))
    assert np.all(apart <= [0.15, 0.35, 0.3] * np.array(said, float))
    broken = PER_CENT.search(printed[printed.rindex("probability of collapse at 0.35 g:") :])[1]
    assert float(broken) == pytest.approx(float(re.search(r"the same command gives (\d+) %", PAGE)[1]), abs=3)

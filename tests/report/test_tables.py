"""The report's tables and prose."""

from rockdamp.report import tables


def test_code_in_a_cell_is_shown_as_code_and_markup_as_text():
    assert tables.inline("`solve` if a < b") == "<code>solve</code> if a &lt; b"
    assert tables.inline("-3% of u_ins, large-rotation, -a") == "−3&nbsp;% of u<sub>ins</sub>, large-rotation, -a"


def test_prose_loses_its_title_its_links_into_the_tree_its_comments_and_any_markup():
    html = tables.prose(
        "# Title\n\n## Part\n\nSee [this file](other.md), [that page](https://example.org) <b>now</b>.\n"
        "\n<!-- what a tool writes -->\n| a | b |\n|---|---|\n| 1 | 2 |\n<!-- end -->\n"
    )
    assert "Title" not in html and "<h3>Part</h3>" in html
    assert "See this file, " in html and '<a href="https://example.org">that page</a>' in html
    assert "&lt;b&gt;now" in html
    assert "what a tool" not in html and "end" not in html and html.count("<tr>") == 2

"""The report's tables and prose."""

import dataclasses
import re

from rockdamp import report
from rockdamp.report import tables


def test_ranges_by_half_cycle_become_a_table_and_the_parts_lists(short):
    measured = [
        {"quantity": "in total", "values": ["CDC 4"], "by": ""},
        {"quantity": "against their mean", "values": ["6 to 7", "14 to 13"], "by": "half cycle"},
        {"quantity": "more is 1", "values": [], "by": ""},
    ]
    html = report.build(dataclasses.replace(short, claims=[{**short.claims[1], "measured": measured}]))
    shown = html.partition('<article id="claim-claim-1"')[2].partition("</article>")[0]
    assert '<th scope="col">against their mean</th>' in shown
    assert re.findall(r'<tr><th scope="row">(.*?)</th><td>(.*?)</td>', shown) == [("1", "6 to 7"), ("2", "14 to 13")]
    assert "<dt>Measured</dt><dd>in total: CDC 4</dd><dd>more is 1</dd>" in shown
    assert "<dt>Condition</dt><dd>condition 1</dd>" in shown
    assert re.findall(r'<dt class="(\w+)-tick"><span .*?</span> (.*?)</dt>(.*)', shown) == [
        ("no", "Does not hold", "<dd>no part of 1</dd>"),
        ("partly", "Holds in part", "<dd>some part of 1 (e 0.1)</dd>"),
        ("yes", "Holds", "<dd>this part of 1</dd><dd>that part of 1</dd>"),
    ]


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

"""The report's tables and prose."""

import dataclasses

import pytest
from repository import ROOT

from rockdamp import report
from rockdamp.config import between_keys as checks
from rockdamp.errors import InputError
from rockdamp.report import tables
from rockdamp.text import number


def test_a_table_without_a_column_or_with_a_short_row_is_refused(tmp_path):
    path = tmp_path / "claims.csv"
    path.write_text("id,section\na,1\n", encoding="utf-8")
    with pytest.raises(InputError, match="has no column claim, verdict, measured"):
        tables.rows(path, tables.CLAIMS)
    path.write_text("id,where\na,1\nb\n", encoding="utf-8")
    with pytest.raises(InputError, match="row 2 has not as many cells"):
        tables.rows(path, ("id", "where"))
    path.write_text('id,where\na,"one, two"\n', encoding="utf-8")
    assert tables.rows(path, ("id", "where")) == [{"id": "a", "where": "one, two"}]


def test_what_was_measured_stands_in_parts_with_their_numbers():
    assert tables.parts("areas: -8% to 9%; -5% to 4%; against CR: 0.1; 0.2") == [
        "areas: -8% to 9%; -5% to 4%",
        "against CR: 0.1; 0.2",
    ]
    assert tables.parts("0.3; of all: one") == ["0.3", "of all: one"]


def test_ranges_by_half_cycle_become_a_table_and_the_parts_lists(content):
    measured = "in total: CDC -4%; half cycle by half cycle against their mean: -6% to 7%; -14% to 13%; more: 1"
    condition = "the length was inferred; holds: in total; does not hold: each half cycle"
    claim = {**content.claims[1], "measured": measured, "condition": condition}
    (shown,) = [one for group in tables.judged([claim], {}) for one in group["claims"]]
    assert shown["half_cycles"] == [{"against": "their mean", "ranges": ["-6% to 7%", "-14% to 13%"]}]
    assert shown["measured"] == ["in total: CDC -4%", "more: 1"] and shown["reasons"] == ["the length was inferred"]
    marks = [(part["kind"], part["words"]) for part in shown["parts"]]
    assert marks == [
        ("no", "no part of 1"),
        ("partly", "some part of 1 (e 0.1)"),
        ("yes", "this part of 1"),
        ("yes", "that part of 1"),
    ]


def test_code_in_a_cell_is_shown_as_code_and_markup_as_text():
    assert tables.inline("`solve` if a < b") == "<code>solve</code> if a &lt; b"
    assert tables.inline("-3% of u_ins, large-rotation, -a") == "−3&nbsp;% of u<sub>ins</sub>, large-rotation, -a"


def test_an_unknown_verdict_is_refused(short):
    claims = [{**short.claims[0], "verdict": "likely"}]
    with pytest.raises(InputError, match="the verdict of claim-0 is 'likely'; it must be one of not reproduced, "):
        report.build(dataclasses.replace(short, claims=claims))


def test_a_figure_that_is_no_png_is_refused(short):
    with pytest.raises(InputError, match="the PNG of .* cannot be read; delete it"):
        report.build(dataclasses.replace(short, figures={"fig1": b"%PDF-1.7, or so it says here"}))


def test_prose_loses_its_title_its_links_into_the_tree_its_comments_and_any_markup():
    html = tables.prose(
        "# Title\n\n## Part\n\nSee [this file](other.md), [that page](https://example.org) <b>now</b>.\n"
        "\n<!-- what a tool writes -->\n| a | b |\n|---|---|\n| 1 | 2 |\n<!-- end -->\n"
    )
    assert "Title" not in html and "<h3>Part</h3>" in html
    assert "See this file, " in html and '<a href="https://example.org">that page</a>' in html
    assert "&lt;b&gt;now" in html
    assert "what a tool" not in html and "end" not in html and html.count("<tr>") == 2


def test_quantities_are_told_by_model_or_by_their_extremes(content):
    told = {row["name"]: row for row in tables.quantities(content.datasets["accuracy"])}
    share = content.datasets["accuracy"]["share_within_thousandth"]
    assert told["share_within_thousandth"]["value"].startswith(f"{number(share[0])} (CDC), ")
    lost = content.datasets["accuracy"]["energy_lost"]
    assert told["energy_lost"]["value"] == f"{number(lost.min())} to {number(lost.max())}"
    assert told["energy_lost"]["units"] == "J"


def test_a_config_without_png_is_refused_since_the_report_shows_it(content, monkeypatch):
    monkeypatch.chdir(ROOT)
    config = {**content.config, "figures": {"formats": ["pdf", "svg"], "resolution": 200}}
    assert [str(problem) for problem in checks.problems(config)] == [
        "figures.formats is ['pdf', 'svg']; png must be among them, as the report shows it"
    ]

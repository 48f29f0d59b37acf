"""The report: self-contained, complete, the same bytes each time."""

import dataclasses
import json

import report_content
from html_page import Page, words

from rockdamp import report
from rockdamp.report import tables

REFERENCES = ("src", "href", "srcset", "action", "poster", "data", "xlink:href", "background", "cite")
SECTIONS = [
    "question",
    "use",
    "force",
    "paper",
    "claims",
    "earthquakes",
    "rocking",
    "assumptions",
    "errata",
    "versions",
]


def test_nothing_is_loaded_from_outside_the_page(page):
    loaded = [element for element in page.elements if element["tag"] != "a"]
    found = [element["attrs"][name] for element in loaded for name in REFERENCES if name in element["attrs"]]
    assert found
    assert [value[:60] for value in found if not value.startswith(("#", "data:"))] == []
    styles = "".join(element["text"] for element in page.all("style"))
    assert "@import" not in styles and "url(" not in styles
    (policy,) = [one["attrs"]["content"] for one in page.all("meta") if "http-equiv" in one["attrs"]]
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == "'none'"
    assert all("http" not in sources and "*" not in sources for sources in rules.values())


def test_the_same_content_gives_the_same_bytes(html):
    assert report.build(report_content.content()) == html


def test_the_answer_comes_first_and_the_page_of_the_paper_has_the_same_parts_without_what_goes_beyond(page, content):
    assert [section["attrs"]["id"] for section in page.all("section")] == SECTIONS
    beyond = ("order", "comparison", "supports", "loss_law", "measured_rocking")
    datasets = {name: data for name, data in content.datasets.items() if name not in beyond}
    figures = {name: png for name, png in content.figures.items() if not name.startswith("fig_")}
    paper = Page(report.build(dataclasses.replace(content, datasets=datasets, figures=figures)))
    assert [one["attrs"]["id"] for one in paper.all("section")] == ["question", "paper", "claims", "errata", "versions"]
    named = {one["attrs"]["id"] for one in paper.elements if "id" in one["attrs"]}
    linked = {link["attrs"]["href"] for link in paper.all("a") if link["attrs"]["href"].startswith("#")}
    assert {href[1:] for href in linked} <= named


def test_every_claim_is_there_with_its_verdict_what_fails_first(page, content):
    rows = {row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]}
    for claim in content.claims:
        shown = (claim[name] for name in ("id", "section", "claim", "verdict", "measured", "finding"))
        assert all(words.replace("u_ins", "uins") in rows[f"claim-{claim['id']}"] for words in shown)
    groups = [one["attrs"]["id"] for one in page.all("tbody") if "id" in one["attrs"]]
    assert groups == ["verdict-no", "verdict-partly", "verdict-unknown", "verdict-yes"]
    for erratum in content.errata:
        assert all(cell in rows[f"erratum-{erratum['id']}"] for cell in erratum.values())


def test_every_figure_is_there_once_with_its_picture_and_text(page, content):
    names = [figure["attrs"]["id"] for figure in page.all("figure")]
    assert sorted(names) == sorted(content.figures) and names[:2] == ["fig4", "fig_order"]
    for name, image in zip(names, page.all("img"), strict=True):
        png = content.figures[name]
        width, height = (int.from_bytes(png[at : at + 4], "big") for at in (16, 20))
        assert (image["attrs"]["width"], image["attrs"]["height"]) == (str(width), str(height))
        assert image["attrs"]["src"].startswith("data:image/png;base64,")


def test_the_numbers_of_the_datasets_stand_in_the_page(page, content):
    text, data = words(page.by_id("main")["text"]).replace("\u00a0", " "), content.datasets
    shaken = tables.earthquakes(data["comparison"], data["earthquakes/walls"])
    rows = [cells for *_, cells in shaken["errors"]] + shaken["walls"] + [cells for _, cells in shaken["by_band"]]
    rows += [row["errors"] for row in tables.order(data["order"])["rows"]]
    for cells in rows:
        for cell in cells:
            plain = words(Page(f"<p>{cell}</p>").all("p")[0]["text"]).replace("\u00a0", " ")
            assert plain in text
    for sentence in tables.measured_rocking(data["measured_rocking"])["sentences"]:
        assert sentence in text


def test_the_sliders_begin_at_the_study_s_e_and_the_curve_s_a1(page, content):
    programs = page.by_id("programs")["attrs"]
    stored = json.loads(programs["data-ratios"])
    assert stored == tables.ratios(content.datasets["equivalence"])
    e = json.loads(programs["data-studied"])
    first = e[len(e) // 2]
    assert page.by_id("slider-e")["attrs"]["value"] == str(first)
    assert page.by_id("slider-a1")["attrs"]["value"] == "0.04"
    cells = {one["attrs"]["data-model"]: one["text"] for one in page.all("td") if "data-model" in one["attrs"]}
    assert cells == {model: tables.ratio_at(stored, model, first, 0.04) for model in cells} and cells

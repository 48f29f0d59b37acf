"""The report: self-contained, complete, the same bytes each time."""

import dataclasses

import report_content
import yaml
from html_page import Page, words

from rockdamp import report
from rockdamp.report import tables
from rockdamp.report.page import BRIDGE, ROCKING

REFERENCES = ("src", "href", "srcset", "action", "poster", "data", "xlink:href", "background", "cite")

# --- self-contained, the same each time ------------------------------------------------------------------------------


def test_nothing_is_loaded_from_outside_the_page(page):
    loaded = [element for element in page.elements if element["tag"] != "a"]
    found = [element["attrs"][name] for element in loaded for name in REFERENCES if name in element["attrs"]]
    assert found
    assert [value[:60] for value in found if not value.startswith(("#", "data:"))] == []
    styles = "".join(element["text"] for element in page.all("style"))
    assert "@import" not in styles and "url(" not in styles


def test_the_browser_is_told_to_load_nothing(page):
    (policy,) = [one["attrs"]["content"] for one in page.all("meta") if "http-equiv" in one["attrs"]]
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == "'none'"
    assert all("http" not in sources and "*" not in sources for sources in rules.values())


def test_the_same_content_gives_the_same_bytes(content, html):
    assert report.build(report_content.content()) == html


# --- complete --------------------------------------------------------------------------------------------------------


def test_every_claim_is_there_with_its_verdict_in_words(page, content):
    told = {one["attrs"]["id"]: words(one["text"]) for one in page.all("article")}
    grouped = {}
    for group in (one for one in page.all("div") if one["attrs"].get("class") == "group"):
        grouped |= {name: group["text"] for name in told if told[name] in words(group["text"])}
    for claim in content.claims:
        text = told[f"claim-{claim['id']}"]
        for field in ("id", "section", "claim", "threshold"):
            assert claim[field] in text
        for field in ("reasons", "holds", "holds_in_part", "does_not_hold"):
            assert all(words in text for words in claim[field])
        for item in claim["measured"]:
            assert item["quantity"] in text and all(value in text for value in item["values"])
        assert claim["finding"].replace("u_ins", "uins") in text
        assert words(grouped[f"claim-{claim['id']}"]).split(" ", 1)[1].startswith(claim["verdict"])


def test_what_fails_comes_first_and_no_empty_group_is_shown(page, short):
    groups = [one["attrs"]["id"] for one in page.all("div") if one["attrs"].get("class") == "group"]
    assert groups == ["verdict-no", "verdict-partly", "verdict-unknown", "verdict-yes"]
    less = dataclasses.replace(short, claims=[one for one in short.claims if one["verdict"] == "reproduced"])
    few = Page(report.build(less))
    assert [one["attrs"]["id"] for one in few.all("div") if one["attrs"].get("class") == "group"] == ["verdict-yes"]
    assert [one["attrs"]["data-verdict"] for one in few.all("button") if "data-verdict" in one["attrs"]] == ["yes"]


def test_a_claim_links_to_the_figure_that_shows_it(page, short):
    links = [link for link in page.all("a") if "article" in link["within"]]
    linked = [one for one in (*short.claims, *short.measured) if one["figure"] == "fig5"]
    assert [(link["attrs"]["href"], link["text"]) for link in links] == [("#fig5", "Fig. 5")] * len(linked)
    assert {one["id"] for one in linked} == {"claim-1", "claim-3"}
    few = Page(report.build(dataclasses.replace(short, figures={})))
    assert not [link for link in few.all("a") if "article" in link["within"]]


def test_the_answer_comes_first_then_the_bridge_earthquakes_figures_and_claims(page):
    order = [section["attrs"]["id"] for section in page.all("section")]
    assert order == [
        "answer",
        "bridge",
        "earthquakes",
        "measurement",
        "figures",
        "claims",
        "errata",
        "assumptions",
        "cite",
        "versions",
    ]
    assert "how many of its claims come out again" in words(page.by_id("answer")["text"])


def test_every_erratum_is_there(page, content):
    told = {row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]}
    for erratum in content.errata:
        assert all(cell in told[f"erratum-{erratum['id']}"] for cell in erratum.values())


def test_every_figure_is_there_in_order_with_its_picture_and_text(page, content):
    apart = [BRIDGE, ROCKING]  # the others as they were
    order = [*apart, *(name for name in content.figures if name not in apart)]
    assert [figure["attrs"]["id"] for figure in page.all("figure")] == order
    assert len(page.all("figcaption")) == len(page.all("img")) == len(content.figures)
    for figure, image in zip((content.figures[name] for name in order), page.all("img"), strict=True):
        width, height = (int.from_bytes(figure[at : at + 4], "big") for at in (16, 20))
        assert (image["attrs"]["width"], image["attrs"]["height"]) == (str(width), str(height))
        assert image["attrs"]["src"].startswith("data:image/png;base64,")


def test_versions_and_the_citation_are_there(page, content):
    told = words(page.by_id("versions")["text"])
    for name, version in tables.software():
        assert f"{name} {version}" in told
    for name, data in content.datasets.items():
        assert f"{name}.nc {data.attrs['title']} {data.attrs['code_version']}" in told
    cite = words(page.by_id("cite")["text"])
    cff = yaml.safe_load(content.citation)
    assert cff["title"] in cite and cff["version"] in cite and cff["authors"][0]["name"] in cite

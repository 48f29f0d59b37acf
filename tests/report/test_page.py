"""The report: self-contained, complete, the same bytes each time."""

import report_content
import yaml
from html_page import words

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


def test_every_claim_is_there_with_its_verdict_what_fails_first(page, content):
    rows = {row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]}
    for claim in content.claims:
        text = rows[f"claim-{claim['id']}"]
        assert all(claim[field].replace("u_ins", "uins") in text for field in claim)
    groups = [one["attrs"]["id"] for one in page.all("tbody") if "id" in one["attrs"]]
    assert groups == ["verdict-no", "verdict-partly", "verdict-unknown", "verdict-yes"]


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
    assert "how many of its claims hold" in words(page.by_id("answer")["text"])


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

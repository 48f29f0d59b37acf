"""The report of the minimal build: self-contained, complete, readable by all."""

import base64
import json
import re
from itertools import pairwise

import numpy as np
import pytest
from html_page import Page, words

from rockdamp.report import tables
from rockdamp.storage import dataset

REFERENCES = (
    "src",
    "href",
    "srcset",
    "action",
    "poster",
    "data",
    "xlink:href",
    "background",
    "cite",
)
PAPER = ["question", "paper", "claims", "errata", "versions"]
BEYOND = ["use", "dampers", "force", "earthquakes", "rocking", "assumptions"]


@pytest.fixture(scope="module", params=["report", "paper"])
def page(request, minimal):
    return Page((minimal / f"{request.param}.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def report(minimal):
    return Page((minimal / "report.html").read_text(encoding="utf-8"))


def test_nothing_is_loaded_from_outside(page):
    loaded = [element for element in page.elements if element["tag"] != "a"]
    links = [
        element["attrs"][name]
        for element in loaded
        for name in REFERENCES
        if name in element["attrs"]
    ]
    assert links and all(value.startswith(("#", "data:")) for value in links)
    styles = "".join(element["text"] for element in page.all("style"))
    assert "@import" not in styles and "url(" not in styles
    (policy,) = [
        one["attrs"]["content"] for one in page.all("meta") if "http-equiv" in one["attrs"]
    ]
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == "'none'"
    assert all("http" not in sources and "*" not in sources for sources in rules.values())


def test_names_are_unique_and_links_find_them(page):
    names = [element["attrs"]["id"] for element in page.elements if "id" in element["attrs"]]
    assert len(names) == len(set(names))
    for element in page.elements:
        for attribute in ("for", "aria-labelledby"):
            assert element["attrs"].get(attribute, names[0]) in names
        if element["attrs"].get("href", "").startswith("#"):
            assert element["attrs"]["href"][1:] in names


def test_headings_descend_one_level_at_a_time(page):
    levels = [int(one["tag"][1]) for one in page.elements if re.fullmatch("h[1-6]", one["tag"])]
    assert levels.count(1) == 1 and levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_pictures_and_sliders_have_names(page):
    alternatives = [image["attrs"]["alt"] for image in page.all("img")]
    assert all(alternatives) and len(set(alternatives)) == len(alternatives)
    assert {one["attrs"]["id"] for one in page.all("input")} <= {
        one["attrs"]["for"] for one in page.all("label")
    }


def contrast(one, other):
    def luminance(colour):
        parts = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_text_has_the_contrast_of_wcag_aa_by_day_and_night(report):
    light, _, dark = report.all("style")[0]["text"].partition("prefers-color-scheme: dark")
    for part in (light, dark.partition("figure img")[0]):
        colours = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", part))
        pairs = [
            (text, ground) for text in ("ink", "quiet", "accent") for ground in ("paper", "tint")
        ]
        pairs += [
            (f"{kind}-ink", ground)
            for kind, _ in tables.MARKS.values()
            for ground in ("paper", f"{kind}-ground")
        ]
        assert all(contrast(colours[text], colours[ground]) >= 4.5 for text, ground in pairs)


def test_the_page_of_the_paper_has_the_parts_of_the_report_without_what_goes_beyond(
    minimal, report
):
    sections = [section["attrs"]["id"] for section in report.all("section")]
    assert sections[:2] == ["question", "use"] and sorted(sections) == sorted(PAPER + BEYOND)
    paper = Page((minimal / "paper.html").read_text(encoding="utf-8"))
    assert [section["attrs"]["id"] for section in paper.all("section")] == PAPER


def test_every_claim_is_there_with_its_verdict_what_fails_first(minimal, page):
    rows = {
        row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]
    }
    for claim in tables.read_rows(minimal / "claims.csv"):
        for name in ("section", "claim", "verdict", "measured", "finding"):
            cell = words(Page(f"<p>{tables.inline(claim[name])}</p>").all("p")[0]["text"])
            assert cell in rows[f"claim-{claim['id']}"]
    groups = [one["attrs"]["id"] for one in page.all("tbody") if "id" in one["attrs"]]
    order = ["verdict-no", "verdict-partly", "verdict-unknown", "verdict-yes"]
    assert groups == [name for name in order if name in groups]


def test_every_figure_is_there_once(minimal, report):
    names = [figure["attrs"]["id"] for figure in report.all("figure")]
    assert (
        sorted(names) == sorted(path.stem for path in (minimal / "figures").glob("*.png"))
        and names[0] == "fig4"
    )
    for name, image in zip(names, report.all("img"), strict=True):
        png = base64.b64decode(image["attrs"]["src"].removeprefix("data:image/png;base64,"))
        assert png == (minimal / f"figures/{name}.png").read_bytes()
        size = [int.from_bytes(png[at : at + 4], "big") for at in (16, 20)]
        assert [int(image["attrs"][side]) for side in ("width", "height")] == size


def test_the_numbers_of_the_datasets_stand_in_the_page(minimal, report):
    text = words(report.by_id("main")["text"])
    names = ("comparison", "earthquakes/walls", "order", "measured_rocking")
    compared, walls, order, rocking = (dataset.read(minimal / f"{name}.nc") for name in names)
    shown = tables.earthquakes(compared, walls)
    rows = (
        [cells for *_, cells in shown["errors"]]
        + shown["walls"]
        + [cells for _, cells in shown["by_band"]]
    )
    rows += [row["errors"] for row in tables.order(order)["rows"]]
    for cell in np.concatenate(rows):
        assert words(Page(f"<p>{cell}</p>").all("p")[0]["text"]) in text
    assert all(sentence in text for sentence in tables.measured_rocking(rocking)["sentences"])


def test_the_sliders_begin_at_the_study_s_e_and_the_curve_s_a1(minimal, report):
    programs = report.by_id("dampers"), report.by_id("programs")["attrs"]
    stored = json.loads(programs[1]["data-ratios"])
    assert stored == tables.ratios(dataset.read(minimal / "equivalence.nc"))
    e = json.loads(programs[1]["data-studied"])
    first = e[len(e) // 2]
    assert report.by_id("slider-e")["attrs"]["value"] == str(first)
    assert report.by_id("slider-a1")["attrs"]["value"] == "0.04"
    cells = {
        one["attrs"]["data-model"]: one["text"]
        for one in report.all("td")
        if "data-model" in one["attrs"]
    }
    assert (
        cells == {model: tables.ratio_at(stored, model, first, 0.04) for model in cells} and cells
    )

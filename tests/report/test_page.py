"""The report of the minimal build: self-contained, complete, readable by all."""

import base64
import json
import re
from itertools import pairwise

import numpy as np
import pytest
from html_page import Page, words

from rockdamp.constants import MODELS
from rockdamp.report import tables
from rockdamp.report.page import describe_figures, png_size
from rockdamp.storage import dataset

LOADING = (
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
PAPER_SECTIONS = ["question", "words", "paper", "claims", "errata", "versions"]
OTHER_SECTIONS = ["use", "dampers", "force", "earthquakes", "rocking", "assumptions"]
VERDICT_ORDER = ["verdict-no", "verdict-partly", "verdict-unknown", "verdict-yes"]


@pytest.fixture(scope="module", params=["report", "paper"])
def page(request, minimal):
    return Page((minimal / f"{request.param}.html").read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def report(minimal):
    return Page((minimal / "report.html").read_text(encoding="utf-8"))


def cell_words(html):
    """Return the text of a cell as the page shows it."""
    (cell,) = Page(f"<p>{html}</p>").all("p")
    return words(cell["text"])


def attributes(page, tag, name):
    """Return an attribute of all elements of a tag that have it."""
    return [
        element["attrs"][name]
        for element in page.elements
        if element["tag"] == tag and name in element["attrs"]
    ]


# --- a page by itself --------------------------------------------------------------------------


def test_nothing_is_loaded_from_outside(page):
    links = []
    for element in page.elements:
        if element["tag"] != "a":
            links += [element["attrs"][name] for name in LOADING if name in element["attrs"]]
    assert links
    assert all(link.startswith(("#", "data:")) for link in links)
    styles = "".join(element["text"] for element in page.all("style"))
    assert "@import" not in styles
    assert "url(" not in styles


def test_browser_may_load_nothing_from_outside(page):
    policies = [meta for meta in page.all("meta") if "http-equiv" in meta["attrs"]]
    (policy,) = (meta["attrs"]["content"] for meta in policies)
    rules = dict(rule.split(" ", 1) for rule in policy.split("; "))
    assert rules["default-src"] == "'none'"
    assert not any("http" in sources or "*" in sources for sources in rules.values())


def test_names_are_unique_and_links_find_them(page):
    names = [element["attrs"]["id"] for element in page.elements if "id" in element["attrs"]]
    assert len(names) == len(set(names))
    for element in page.elements:
        for attribute in ("for", "aria-labelledby"):
            assert element["attrs"].get(attribute, names[0]) in names
        link = element["attrs"].get("href", "")
        if link.startswith("#"):
            assert link[1:] in names


def test_headings_descend_one_level_at_a_time(page):
    headings = [element for element in page.elements if re.fullmatch("h[1-6]", element["tag"])]
    levels = [int(heading["tag"][1]) for heading in headings]
    assert levels.count(1) == 1
    assert levels[0] == 1
    assert all(lower <= level + 1 for level, lower in pairwise(levels))


def test_pictures_have_a_text_of_their_own(page):
    alternatives = attributes(page, "img", "alt")
    assert all(alternatives)
    assert len(set(alternatives)) == len(alternatives)


def test_sliders_have_labels(page):
    assert set(attributes(page, "input", "id")) <= set(attributes(page, "label", "for"))


def contrast(text, ground):
    """Return the contrast of two colours by WCAG 2."""

    def luminance(colour):
        parts = np.array([int(colour[start : start + 2], 16) / 255 for start in (1, 3, 5)])
        linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
        return float(linear @ [0.2126, 0.7152, 0.0722])

    dark, light = sorted([luminance(text), luminance(ground)])
    return (light + 0.05) / (dark + 0.05)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_has_the_contrast_of_wcag_aa(report, scheme):
    styles = report.all("style")[0]["text"]
    light, _, dark = styles.partition("prefers-color-scheme: dark")
    rules = light if scheme == "light" else dark.partition("figure img")[0]
    colours = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", rules))
    pairs = [(text, ground) for text in ("ink", "quiet", "accent") for ground in ("paper", "tint")]
    for kind, _ in tables.VERDICT_MARKS.values():
        pairs += [(f"{kind}-ink", "paper"), (f"{kind}-ink", f"{kind}-ground")]
    assert all(contrast(colours[text], colours[ground]) >= 4.5 for text, ground in pairs)


# --- what it shows -----------------------------------------------------------------------------


def test_report_has_every_section(report):
    sections = attributes(report, "section", "id")
    assert sections[:2] == ["question", "use"]
    assert sorted(sections) == sorted(PAPER_SECTIONS + OTHER_SECTIONS)


def test_page_of_the_paper_has_its_sections_alone(minimal):
    page = Page((minimal / "paper.html").read_text(encoding="utf-8"))
    assert attributes(page, "section", "id") == PAPER_SECTIONS


def test_every_model_is_explained(page):
    text = words(page.by_id("words")["text"])
    for damper in tables.dampers():
        assert f"{damper['model']} {damper['title']} {cell_words(damper['formula'])}" in text
    assert [damper["model"] for damper in tables.dampers()] == list(MODELS)


def test_every_symbol_is_explained(page):
    text = words(page.by_id("words")["text"])
    for symbol, meaning in tables.symbols():
        assert f"{cell_words(symbol)} {cell_words(meaning)}" in text


def test_every_table_has_a_caption_or_a_heading(report):
    scrolling = [
        table for table in report.all("table") if "stacked" not in table["attrs"].get("class", "")
    ]
    assert len(report.all("caption")) == len(scrolling)


def test_answer_states_errors_of_band_and_cdc(minimal, report):
    compared = dataset.read(minimal / "comparison.nc")
    (answer,) = (p for p in report.all("p") if p["attrs"].get("class") == "answer")
    middle = compared.sizes["restitution"] // 2
    for row in (tables.programs(compared)[0], tables.programs(compared)[-1]):
        for errors in (row["errors"][0], row["errors"][2]):
            assert words(errors[middle]) in words(answer["text"])


def test_page_of_another_config_says_so(page):
    notes = [words(p["text"]) for p in page.all("p") if p["attrs"].get("class") == "note"]
    assert notes[0].startswith("These results, in results/minimal, are not those of the default")


def test_answer_of_the_paper_states_damping_ratios(minimal):
    page = Page((minimal / "paper.html").read_text(encoding="utf-8"))
    (answer,) = (p for p in page.all("p") if p["attrs"].get("class") == "answer")
    xi = dataset.read(minimal / "equivalence.nc")["damping_ratio"]
    at_paper_values = xi.sel(restitution=0.85, yield_displacement_ratio=0.04, method="nearest")
    cdc, cdr = (100 * float(at_paper_values.sel(damping_model=model)) for model in ("CDC", "CDR"))
    assert f"{cdc:.2f} % for CDC and {cdr:.2f} % for CDR" in words(answer["text"])
    verdicts = [row["verdict"] for row in tables.read_rows(minimal / "claims.csv")]
    count = f"{verdicts.count('holds')} of its {len(verdicts)} claims hold"
    assert count in words(answer["text"])


def test_every_claim_has_its_verdict(minimal, page):
    rows = {
        row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]
    }
    for claim in tables.read_rows(minimal / "claims.csv"):
        for name in ("section", "claim", "verdict", "measured", "finding"):
            assert cell_words(tables.inline(claim[name])) in rows[f"claim-{claim['id']}"]


def test_claims_that_fail_come_first(page):
    groups = attributes(page, "tbody", "id")
    assert groups == [name for name in VERDICT_ORDER if name in groups]


def test_every_figure_is_there_once(minimal, report):
    names = attributes(report, "figure", "id")
    assert sorted(names) == sorted(path.stem for path in (minimal / "figures").glob("*.png"))
    assert names[0] == "fig4"
    for name, image in zip(names, report.all("img"), strict=True):
        encoded = image["attrs"]["src"].removeprefix("data:image/png;base64,")
        png = base64.b64decode(encoded)
        assert png == (minimal / f"figures/{name}.png").read_bytes()
        assert (int(image["attrs"]["width"]), int(image["attrs"]["height"])) == png_size(png)


def png(width, height):
    """Return the start of an image of a size."""
    return bytes(16) + width.to_bytes(4, "big") + height.to_bytes(4, "big")


def test_figures_have_their_share_of_the_widest():
    figures = describe_figures({"fig2": png(300, 80), "fig1": png(150, 50)})
    assert list(figures) == ["fig1", "fig2"]
    assert (figures["fig1"]["width"], figures["fig1"]["height"]) == (150, 50)
    assert [figure["share"] for figure in figures.values()] == [0.5, 1.0]


@pytest.fixture(scope="module")
def main_text(report):
    return words(report.by_id("main")["text"])


def test_numbers_of_the_earthquakes_stand_in_the_page(minimal, main_text):
    compared = dataset.read(minimal / "comparison.nc")
    walls = dataset.read(minimal / "earthquakes/walls.nc")
    values = tables.earthquakes(compared, walls)
    rows = [cells for *_, cells in values["errors"]]
    rows += [cells for _, cells in values["by_band"]]
    for cells in [*rows, *values["walls"]]:
        assert all(cell_words(cell) in main_text for cell in cells)


def test_numbers_of_the_dampers_stand_in_the_page(minimal, main_text):
    for row in tables.order(dataset.read(minimal / "order.nc"))["rows"]:
        assert all(cell_words(cell) in main_text for cell in row["errors"])


def test_sentences_on_trials_stand_in_the_page(minimal, main_text):
    rocking = tables.measured_rocking(dataset.read(minimal / "measured_rocking.nc"))
    assert all(words(sentence) in main_text for sentence in rocking["sentences"])


def test_sliders_start_at_the_middle_e_and_the_a1_of_the_curve(minimal, report):
    group = report.by_id("programs")["attrs"]
    stored = json.loads(group["data-ratios"])
    assert stored == tables.ratios(dataset.read(minimal / "equivalence.nc"))
    studied = json.loads(group["data-studied"])
    middle = studied[len(studied) // 2]
    assert report.by_id("slider-e")["attrs"]["value"] == str(middle)
    assert report.by_id("slider-a1")["attrs"]["value"] == "0.04"
    cells = [cell for cell in report.all("td") if "data-model" in cell["attrs"]]
    assert cells
    for cell in cells:
        assert cell["text"] == tables.ratio_at(stored, cell["attrs"]["data-model"], middle, 0.04)

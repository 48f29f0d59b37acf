"""The report: complete, self-contained, the same bytes each time, readable by all, with every number from a dataset."""

import dataclasses
import json
import re
import socket
from html.parser import HTMLParser
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
import report_content
import yaml
from repository import ROOT

from rockdamp import report
from rockdamp.config import between_keys as checks
from rockdamp.equivalence.closed_form import NODES, PLATEAU_PIECES, WEIGHTS
from rockdamp.errors import InputError
from rockdamp.figures import FIGURES
from rockdamp.report import captions, interactive, numbers, tables
from rockdamp.storage.provenance import files_of

VOID = {"meta", "link", "img", "input", "br", "hr", "line"}
APART = {"td", "th", "tr", "li", "p", "h2", "h3", "caption"}  # what text a browser sets apart
REFERENCES = ("src", "href", "srcset", "action", "poster", "data", "xlink:href", "background", "cite")


class Page(HTMLParser):
    """Elements in order, with attributes and the text within each; complains where tags do not nest."""

    def __init__(self, html):
        super().__init__(convert_charrefs=True)
        self.elements, self.open = [], []
        self.feed(html)
        self.close()
        assert not self.open, f"not closed: {[element['tag'] for element in self.open]}"

    def handle_starttag(self, tag, attrs):
        if tag in APART:
            self.handle_data(" ")
        element = {"tag": tag, "attrs": dict(attrs), "text": "", "within": [one["tag"] for one in self.open]}
        self.elements.append(element)
        if tag not in VOID:
            self.open.append(element)

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open and self.open[-1]["tag"] == tag, f"</{tag}> where {[one['tag'] for one in self.open]} are open"
        self.open.pop()

    def handle_data(self, data):
        for element in self.open:
            element["text"] += data

    def all(self, tag):
        return [element for element in self.elements if element["tag"] == tag]

    def by_id(self, name):
        (element,) = [element for element in self.elements if element["attrs"].get("id") == name]
        return element


def words(text):
    return " ".join(text.split())


@pytest.fixture(scope="module")
def content():
    return report_content.content()


@pytest.fixture(scope="module")
def html(content):
    return report.build(content)


@pytest.fixture(scope="module")
def page(html):
    return Page(html)


# --- self-contained, the same each time ------------------------------------------------------------------------------


def test_nothing_is_loaded_from_outside_the_page(page):
    found = [element["attrs"][name] for element in page.elements for name in REFERENCES if name in element["attrs"]]
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


def test_no_place_and_no_host_stands_in_the_page(html):
    assert str(ROOT) not in html
    assert str(Path.home()) not in html or str(Path.home()) == "/"
    host = socket.gethostname()
    assert len(host) < 6 or host not in html


def test_a_script_cannot_end_early(html, page):
    assert html.count("<script") == html.count("</script>") == len(page.all("script"))
    assert "evidence 1 &lt;/script&gt;" in html


def test_data_for_the_scripts_cannot_end_its_element(content, monkeypatch):
    monkeypatch.setitem(interactive.TITLES, "CR", "</script><b>")
    data = Page(report.build(content)).by_id("explorer-data")["text"]
    assert json.loads(data)["styles"]["CR"]["title"] == "</script><b>"


def test_every_file_of_the_report_is_an_input_of_its_rule():
    folder = ROOT / "src/rockdamp/report"
    own = {path for path in folder.iterdir() if path.is_file()}
    assert own <= set(files_of("rockdamp.report"))


def test_a_report_is_written_whole(content, html, tmp_path):
    report.write(content, tmp_path / "new" / "report.html")
    assert (tmp_path / "new" / "report.html").read_text(encoding="utf-8") == html
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["report.html"]


# --- complete --------------------------------------------------------------------------------------------------------


def test_every_claim_is_there_with_its_verdict_in_words(page, content):
    told = {row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]}
    for claim in content.claims:
        text = told[f"claim-{claim['id']}"]
        for column in tables.CLAIMS:
            assert claim[column] in text
        assert text.count(claim["verdict"]) == 1


def test_verdicts_are_counted_at_the_top(page):
    (short,) = [one for one in page.all("ul") if one["attrs"].get("class") == "counts"]
    assert words(short["text"]) == "2 ✓ reproduced 2 ◐ reproduced under conditions 1 ✗ not reproduced"


def test_what_was_asked_comes_first_then_claims_errata_and_figures(page):
    order = [section["attrs"]["id"] for section in page.all("section")]
    assert order == [
        "claims",
        "errata",
        "earthquakes",
        "figures",
        "explorer",
        "assumptions",
        "accuracy",
        "cite",
        "versions",
    ]
    assert "What was asked" in page.all("header")[0]["text"]


def test_every_erratum_is_there(page, content):
    told = {row["attrs"]["id"]: words(row["text"]) for row in page.all("tr") if "id" in row["attrs"]}
    for erratum in content.errata:
        for column in tables.ERRATA:
            assert erratum[column] in told[f"erratum-{erratum['id']}"]


def test_every_figure_is_there_in_order_with_its_picture_and_text(page, content):
    assert [figure["attrs"]["id"] for figure in page.all("figure")] == list(content.figures)
    assert len(page.all("figcaption")) == len(page.all("img")) == len(content.figures)
    for figure, image in zip(content.figures.values(), page.all("img"), strict=True):
        width, height = (int.from_bytes(figure[at : at + 4], "big") for at in (16, 20))
        assert (image["attrs"]["width"], image["attrs"]["height"]) == (str(width), str(height))
        assert image["attrs"]["src"].startswith("data:image/png;base64,")


def test_the_whole_config_can_be_read_back(page, content):
    (block,) = [one["text"] for one in page.all("pre") if one["text"].startswith("results:")]
    assert yaml.safe_load(block) == content.config


def test_versions_digests_and_the_citation_are_there(page, content):
    told = words(page.by_id("versions")["text"])
    for name, version in tables.software():
        assert f"{name} {version}" in told
    for name, data in content.datasets.items():
        assert (
            f"{name}.nc {data.attrs['title']} {data.attrs['code_version']} {data.attrs['config_sha256'][:16]}" in told
        )
    cite = words(page.by_id("cite")["text"])
    cff = yaml.safe_load(content.citation)
    assert cff["title"] in cite and cff["version"] in cite and cff["authors"][0]["name"] in cite


def test_accuracy_tells_every_variable_with_its_units(page, content):
    told = words(page.by_id("accuracy")["text"])
    for name in content.datasets["accuracy"].data_vars:
        assert content.datasets["accuracy"][name].attrs["long_name"] in told
    lost = content.datasets["accuracy"]["energy_lost"]
    assert f"energy_lost {numbers.number(lost.min())} to {numbers.number(lost.max())} J" in told


def test_without_an_accuracy_dataset_its_section_and_figures_are_left_out(content):
    some = {name: png for name, png in content.figures.items() if name not in ("fig_accuracy", "fig_rigid")}
    less = {name: data for name, data in content.datasets.items() if name != "accuracy"}
    page = Page(report.build(dataclasses.replace(content, datasets=less, figures=some)))
    assert "accuracy" not in [section["attrs"]["id"] for section in page.all("section")]
    assert "#accuracy" not in [link["attrs"]["href"] for link in page.all("a")]


# --- readable by all -------------------------------------------------------------------------------------------------


def test_names_are_unique_and_what_points_to_them_finds_them(page):
    names = [element["attrs"]["id"] for element in page.elements if "id" in element["attrs"]]
    assert len(names) == len(set(names))
    for element in page.elements:
        for attribute in ("for", "aria-labelledby"):
            if attribute in element["attrs"]:
                assert element["attrs"][attribute] in names
        if element["attrs"].get("href", "").startswith("#"):
            assert element["attrs"]["href"][1:] in names


def test_headings_descend_one_level_at_a_time(page):
    levels = [int(one["tag"][1]) for one in page.elements if re.fullmatch("h[1-6]", one["tag"])]
    assert levels.count(1) == 1 and levels[0] == 1
    assert all(after <= before + 1 for before, after in pairwise(levels))


def test_language_viewport_alternatives_and_labels_are_stated(page):
    assert page.all("html")[0]["attrs"]["lang"] == "en"
    (viewport,) = [one["attrs"]["content"] for one in page.all("meta") if one["attrs"].get("name") == "viewport"]
    assert "width=device-width" in viewport and "user-scalable" not in viewport
    alternatives = [image["attrs"]["alt"] for image in page.all("img")]
    assert all(len(text) > 40 for text in alternatives) and len(set(alternatives)) == len(alternatives)
    labelled = {label["attrs"]["for"] for label in page.all("label")}
    for field in [*page.all("input"), *page.all("select")]:
        assert field["attrs"]["id"] in labelled or field["attrs"].get("aria-label")


def test_wide_tables_and_listings_scroll_or_stack(page):
    for element in [*page.all("table"), *page.all("pre")]:
        stacked = element["attrs"].get("class") == "stacked"
        assert stacked or element["within"][-1] == "div"


def luminance(colour):
    parts = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one, other):
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_text_stands_out_from_its_ground_as_wcag_asks(page):
    style = page.all("style")[0]["text"]
    named = dict(re.findall(r"--(\w+): (#[0-9a-f]{6});", style))
    pairs = [(named[text], named[ground]) for text in ("ink", "quiet", "accent") for ground in ("paper", "tint")]
    pairs += re.findall(r"background: (#[0-9a-f]{6});[^}]*?[^-]color: (#[0-9a-f]{6});", style)
    assert len(pairs) >= 10
    for one, other in pairs:
        assert contrast(one, other) >= 4.5  # level AA of WCAG 2 for text of any size


def test_the_contrast_of_black_on_white_is_that_of_the_standard():
    assert contrast("#000000", "#ffffff") == pytest.approx(21)


def test_printing_leaves_out_what_needs_a_screen(page):
    rules = page.all("style")[0]["text"].partition("@media print")[2]
    hidden = re.search(r"([^{}]*)\{ display: none; \}", rules)[1]
    assert ".screen" in hidden and "nav" in hidden
    assert "screen" in page.by_id("explorer")["attrs"]["class"].split()


# --- captions --------------------------------------------------------------------------------------------------------


def test_every_figure_has_a_caption_in_both_reports():
    assert set(captions.words()) == set(captions.VARIABLES) == set(FIGURES)
    for name in FIGURES:
        assert (ROOT / f"workflow/report/{name}.rst").read_text(encoding="utf-8").strip()


@pytest.mark.parametrize("name", list(FIGURES))
def test_no_number_of_a_caption_is_typed(name):
    entry = captions.words()[name]
    text = " ".join((entry["title"], entry["alternative"], entry["caption"]))
    text = re.sub(r"\{\{.*?\}\}|\{%.*?%\}|<sub>\w+</sub>|&nbsp;", " ", text)
    text = re.sub(r"Fig\. +\d+|Eq\. +\(\d+\)|R²", " ", text)
    assert re.findall(r"\d", text) == []


class Watched(dict):
    """Datasets that note which of them are asked for."""

    def __init__(self, *args):
        super().__init__(*args)
        self.asked = set()

    def __getitem__(self, name):
        self.asked.add(name)
        return super().__getitem__(name)


def changed(data):
    """The same coordinates, other values."""
    return data.assign({name: data[name] ** 1.3 for name in data.data_vars if data[name].dtype.kind == "f"})


@pytest.mark.parametrize("name", list(FIGURES))
def test_the_numbers_of_a_caption_follow_its_datasets(name, content):
    datasets = Watched(content.datasets)
    before = captions.caption(name, datasets)
    after = captions.caption(name, {key: changed(data) for key, data in content.datasets.items()})
    assert datasets.asked
    assert re.search(r"\d", before.text)
    assert before.text != after.text
    assert (before.title, before.alternative) == (after.title, after.alternative)


def test_a_caption_tells_the_values_of_the_figure(content):
    fits = content.datasets["equivalence"]
    at = fits.sel(restitution=0.85, cracked_stiffness_ratio=0.04)
    text = captions.caption("fig7", content.datasets).text
    for model in fits["damping_model"].values:
        assert f"{numbers.number(at['damping_ratio_fit'].sel(damping_model=model))} ({model})" in text
    assert str(numbers.number(at["giannini_masiani"])) in text
    assert "a<sub>1</sub>&nbsp;=&nbsp;0.04" in text


def test_a_synthetic_record_is_called_so_and_another_is_not(content):
    test = content.datasets["validation"]
    assert "synthetic" in captions.caption("fig8", content.datasets).text
    real = {**content.datasets, "validation": test.assign_attrs(record_synthetic="no")}
    assert "synthetic" not in captions.caption("fig8", real).text
    unlabelled = test.copy()
    del unlabelled.attrs["record_synthetic"]
    assert "synthetic" in captions.caption("fig8", {**content.datasets, "validation": unlabelled}).text


def test_the_lowest_error_is_told_with_its_range_of_restitution(content):
    one = content.datasets["match/amplitude"].copy(deep=True)
    one["error"][:] = 1.0
    one["error"].loc[{"damping_model": "CDR", "restitution": [0.85, 0.9]}] = 0.5
    one["error"].loc[{"damping_model": "SDR", "restitution": [0.8, 0.95]}] = 0.5
    text = captions.caption("fig6_error", {**content.datasets, "match/amplitude": one}).text
    assert "CDR at e = 0.85 to 0.90 and SDR at e = 0.80 and 0.95" in text


def test_numbers_read_as_people_write_them():
    assert numbers.number(0.0287654) == "0.0288"
    assert numbers.number(123.456, 2) == "123"
    assert numbers.number(-0.5) == "−0.500"
    assert numbers.number(4.0) == "4"
    assert numbers.number(0) == "0"
    assert numbers.number(1.234e-5) == "1.23&nbsp;×&nbsp;10<sup>−5</sup>"
    assert numbers.number(float("nan")) == "not defined"
    assert numbers.percent(0.09456) == "9.5&nbsp;%"
    assert numbers.percent(2e-5) == "less than 0.01&nbsp;%"
    assert numbers.plain(0.5) == "0.5"
    assert numbers.listed(["a"]) == "a"
    assert numbers.listed(["a", "b", "c"]) == "a, b and c"
    assert numbers.ranges([0.8, 0.85, 0.9], [False, False, False]) == "none"


def test_text_of_a_dataset_is_escaped_in_a_caption(content):
    test = content.datasets["validation"].assign_attrs(record_specimen="<b>wall</b>")
    assert "&lt;b&gt;wall" in captions.caption("fig8", {**content.datasets, "validation": test}).text


# --- tables and prose ------------------------------------------------------------------------------------------------


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


def test_code_in_a_cell_is_shown_as_code_and_markup_as_text():
    assert tables.inline("`solve` if a < b") == "<code>solve</code> if a &lt; b"


def test_an_unknown_verdict_is_refused(content):
    claims = [{**content.claims[0], "verdict": "likely"}]
    with pytest.raises(InputError, match="the verdict of claim-0 is 'likely'; it must be one of reproduced, "):
        report.build(dataclasses.replace(content, claims=claims))


def test_a_figure_that_is_no_png_is_refused(content):
    with pytest.raises(InputError, match="the PNG of .* cannot be read; delete it"):
        report.build(dataclasses.replace(content, figures={"fig1": b"%PDF-1.7, or so it says here"}))


def test_prose_loses_its_title_its_links_into_the_tree_and_any_markup():
    html = tables.prose(
        "# Title\n\n## Part\n\nSee [this file](other.md), [that page](https://example.org) <b>now</b>.\n"
    )
    assert "Title" not in html and "<h3>Part</h3>" in html
    assert "See this file, " in html and '<a href="https://example.org">that page</a>' in html
    assert "&lt;b&gt;now" in html


def test_quantities_are_told_by_model_or_by_their_extremes(content):
    told = {row["name"]: row for row in tables.quantities(content.datasets["accuracy"])}
    share = content.datasets["accuracy"]["share_within_thousandth"]
    assert told["share_within_thousandth"]["value"].startswith(f"{numbers.number(share[0])} (CDC), ")
    lost = content.datasets["accuracy"]["energy_lost"]
    assert told["energy_lost"]["value"] == f"{numbers.number(lost.min())} to {numbers.number(lost.max())}"
    assert told["energy_lost"]["units"] == "J"


def test_a_config_without_png_is_refused_since_the_report_shows_it(content, monkeypatch):
    monkeypatch.chdir(ROOT)
    config = {**content.config, "figures": {"formats": ["pdf", "svg"], "resolution": 200}}
    assert [str(problem) for problem in checks.problems(config)] == [
        "figures.formats is ['pdf', 'svg']; png must be among them, as the report shows it"
    ]


# --- what the explorer is given --------------------------------------------------------------------------------------


def test_the_closed_form_is_given_the_packages_constants(content):
    given = interactive.data(content.datasets["explorer"], 0.85, 0.5)["constants"]
    assert given["nodes"] == NODES.tolist() and given["weights"] == WEIGHTS.tolist()
    assert given["plateau_pieces"] == PLATEAU_PIECES


def test_stored_decays_survive_their_rounding_and_a_collapse(content):
    import base64

    data = content.datasets["explorer"].copy(deep=True)
    data["displacement"][1, 2, 3, 40:] = np.nan
    given = interactive.data(data, 0.85, 0.5)["decays"]
    whole = np.frombuffer(base64.b64decode(given["displacement"]), "<i2").reshape(data["displacement"].shape)
    read = np.where(whole == given["missing"], np.nan, whole * given["scale"])
    assert np.array_equal(np.isnan(read), np.isnan(data["displacement"].values))
    np.testing.assert_allclose(read, data["displacement"], rtol=0, atol=0.5e-4 + 1e-12)
    assert given["points"] == data.sizes["tau"] and given["spacing"] == pytest.approx(0.05)


def test_the_explorer_starts_at_the_studys_curve(content):
    given = interactive.data(content.datasets["explorer"], 0.85, 0.5)
    assert given["start"] == {"e": 0.85, "x0": 0.5, "a1": 0.04, "b1": 0.85, "a3": 1.0, "softening": "steeper"}
    assert set(given["presets"]) == {"study", "new", "moderate", "severe"}


def test_dashes_of_the_screen_are_those_of_the_figures():
    assert interactive.dash("solid") == []
    assert interactive.dash((0, (3.0, 1.4))) == [6.0, 2.8]
    assert set(interactive.styles()) == {"CR", "CDC", "CDR", "SDR", "ECD"}

"""The report is readable by all: names, headings, labels, contrast, print."""

import re
from itertools import pairwise

import numpy as np

VERDICTS = ("yes", "partly", "unknown", "no")


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


def luminance(colour):
    parts = np.array([int(colour[at : at + 2], 16) / 255 for at in (1, 3, 5)])
    linear = np.where(parts <= 0.04045, parts / 12.92, ((parts + 0.055) / 1.055) ** 2.4)
    return float(linear @ [0.2126, 0.7152, 0.0722])


def contrast(one, other):
    light, dark = sorted((luminance(one), luminance(other)), reverse=True)
    return (light + 0.05) / (dark + 0.05)


def test_text_stands_out_from_its_ground_as_wcag_asks(page):
    style = page.all("style")[0]["text"]
    light, _, dark = style.partition("prefers-color-scheme: dark")
    for part in (light, dark.partition("figure img")[0]):
        named = dict(re.findall(r"--([\w-]+): (#[0-9a-f]{6});", part))
        pairs = [(text, ground) for text in ("ink", "quiet", "accent") for ground in ("paper", "tint")]
        pairs += [(f"{verdict}-ink", f"{verdict}-ground") for verdict in VERDICTS]
        pairs += [(f"{verdict}-ink", "paper") for verdict in VERDICTS]  # of the ticks
        for text, ground in pairs:
            assert contrast(named[text], named[ground]) >= 4.5  # level AA of WCAG 2 for text of any size
        for edge in ("edge", *(f"{verdict}-edge" for verdict in VERDICTS)):
            assert contrast(named[edge], named["paper"]) >= 3  # the same, for what is not text
    assert not re.findall(r"(?<!-)\b(?:background|color): #(?!ffffff)", style)  # all colours are named

"""The tables of measured numbers in the documents and in the package."""

import re

import calibration_check
import doc_tables
import numpy as np
import pandas as pd
import pytest
import shipped_tables
from coarse_scan import coarse_scan
from page_blocks import read

NUMBER = re.compile(r"(?<!\w)\d+(?:\.\d+)?(?:e-\d+)?(?!\w)")
PAGE_TABLES = {
    block["name"]: block["text"].strip()
    for page in doc_tables.pages()
    for block in doc_tables.BLOCK.finditer(page.read_text(encoding="utf-8"))
}
full_build = pytest.mark.skipif(
    not (doc_tables.RESULTS / "report.html").exists(), reason="no full build"
)


def numbers(text):
    return [float(number) for number in NUMBER.findall(text)]


def test_each_table_is_on_a_page():
    assert set(PAGE_TABLES) == set(doc_tables.TABLES)


@full_build
@pytest.mark.parametrize("name", PAGE_TABLES)
def test_table_of_the_full_build(name):
    text = PAGE_TABLES[name]
    expected = doc_tables.TABLES[name]()
    assert NUMBER.sub("x", text) == NUMBER.sub("x", expected)
    # Another processor may round a last digit otherwise; small percentages have only one.
    tolerance = 0.11 * (name == "closed_form")
    np.testing.assert_allclose(numbers(text), numbers(expected), rtol=0.1, atol=tolerance)


def test_coverage_has_the_columns_of_its_page(monkeypatch):
    monkeypatch.setattr(calibration_check, "TESTS", 2)
    with coarse_scan():
        row = calibration_check.coverage_row("CR", first_seed=1000)
    text = read("docs/measured.md").split("<!-- tools/calibration_check.py coverage -->\n")[1]
    page_row = re.search(r"^\| (CR .*) \|$", text, re.MULTILINE)[1]
    signed_number = re.compile(f"-?{NUMBER.pattern}")
    assert signed_number.sub("x", " | ".join(row)) == signed_number.sub("x", page_row)


@full_build
def test_shipped_shares_of_the_full_build():
    shipped = pd.read_csv(shipped_tables.SHIPPED / "missed_collapses.csv")
    pd.testing.assert_frame_equal(shipped, shipped_tables.missed_collapses())


@full_build
def test_shipped_polynomials_of_the_full_build():
    shipped = pd.read_csv(shipped_tables.SHIPPED / "coefficients.csv")
    built = pd.read_csv(shipped_tables.RESULTS / "coefficients.csv")
    pd.testing.assert_frame_equal(shipped, built, rtol=1e-6)

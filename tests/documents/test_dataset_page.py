"""The page of datasets, against the minimal build."""

from dataset_page import PAGE, make_page


def test_page_of_datasets_is_that_of_a_build(minimal):
    """`python tools/dataset_page.py` writes it."""
    assert PAGE.read_text(encoding="utf-8") == make_page(minimal)

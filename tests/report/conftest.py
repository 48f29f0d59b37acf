"""A report of made-up content: its text and its elements; and one with real decays for the explorer."""

import explorer_parts
import pytest
import report_content
from html_page import Page

from rockdamp import report


@pytest.fixture(scope="session")
def content():
    return report_content.content()


@pytest.fixture(scope="session")
def html(content):
    return report.build(content)


@pytest.fixture(scope="session")
def page(html):
    return Page(html)


@pytest.fixture(scope="session")
def stored():
    return explorer_parts.stored()


@pytest.fixture(scope="session")
def explorer_page(stored, tmp_path_factory):
    """The file of a built page, with the real decays for its explorer."""
    content = report_content.content()
    content.datasets["explorer"] = stored
    path = tmp_path_factory.mktemp("page") / "a träe.html"
    report.write(content, path)
    return path

"""A report of made-up content: its text, its elements and its file."""

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

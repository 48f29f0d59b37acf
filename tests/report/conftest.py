"""A report of made-up content: its text, its elements and its file."""

import dataclasses

import pytest
import report_content
from html_page import Page

from rockdamp import report


@pytest.fixture(scope="session")
def content():
    return report_content.content()


@pytest.fixture(scope="session")
def short(content):
    """With one figure and no section on earthquakes: it is built in a tenth of the time."""
    datasets = {name: data for name, data in content.datasets.items() if name != "earthquakes/walls"}
    return dataclasses.replace(content, figures={"fig5": content.figures["fig5"]}, datasets=datasets)


@pytest.fixture(scope="session")
def html(content):
    return report.build(content)


@pytest.fixture(scope="session")
def page(html):
    return Page(html)

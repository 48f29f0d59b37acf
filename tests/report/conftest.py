"""A report of made-up content: its text, its elements and its file."""

import dataclasses
import json
import shutil
import subprocess

import pytest
import report_content
from html_page import Page

from rockdamp import report


@pytest.fixture(scope="session")
def node():
    """Run a script of the page without a browser: call(folder, script, data) gives what `script` prints as JSON."""
    program = shutil.which("node") or shutil.which("nodejs")
    if program is None:
        pytest.skip("node, which runs the page's scripts without a browser, is absent")

    def call(folder, script, data):
        (folder / "run.js").write_text(script, encoding="utf-8")
        command = [program, folder / "run.js"]
        done = subprocess.run(command, input=json.dumps(data), capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return json.loads(done.stdout)

    return call


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


@pytest.fixture(scope="session")
def explorer_page(html, tmp_path_factory):
    """The file of a built page."""
    path = tmp_path_factory.mktemp("page") / "a träe.html"
    path.write_text(html, encoding="utf-8")
    return path

"""The public names for type checkers and editors, which read the stub and never run the package."""

import json
import re
import subprocess
import sys

import pytest
from repository import ROOT

FIRST = "import rockdamp as rd; CURVE, CR = rd.TrilinearCurve(0.04, 0.85), rd.Damping('CR', 0.85)"
# One mistake a line, and what a type checker says of it.
MISTAKES = {
    "rd.Wal(thickness=0.3, height=4.5)": 'Module has no attribute "Wal"',
    "rd.Wall(thickness=0.3, hight=4.5)": 'Unexpected keyword argument "hight"',
    "rd.read_record(3)": 'Argument 1 to "read_record" has incompatible type "int"',
    "rd.peaks(CURVE, CR, step=0.01, steps=10).displacement": '"Peaks" has no attribute "displacement"',
    "rd.simulate(CURVE, CR, step=0.01, steps=10).error": '"Histories" has no attribute "error"',
    "rd.simulate(CURVE, CR, stop=0.01)": 'Unexpected keyword argument "stop"',
}


def pages():
    """Yield the Python of the pages that show how to use the package, a page in one piece, as a reader goes on."""
    for page in ("README.md", "docs/index.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        yield page, "".join(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    notebook = json.loads((ROOT / "docs/notebooks/explore.ipynb").read_text(encoding="utf-8"))
    yield "explore.ipynb", "\n".join("".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "code")


@pytest.fixture(scope="module")
def checked(tmp_path_factory):
    """Check all files at once, away from the repository's settings, as a user would; return mypy's lines by file."""
    folder = tmp_path_factory.mktemp("typed")
    files = {re.sub(r"\W", "_", page) + ".py": code for page, code in pages()}
    files["mistakes.py"] = "\n".join([FIRST, *MISTAKES])
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    options = ["--strict", "--config-file=", "--hide-error-context", "--no-pretty"]
    run = subprocess.run([sys.executable, "-m", "mypy", *options, *files], cwd=folder, capture_output=True, text=True)
    assert run.returncode in (0, 1), run.stdout + run.stderr
    lines = run.stdout.splitlines()
    return {name: [line for line in lines if line.startswith(f"{name}:")] for name in files}


def test_a_strict_type_checker_passes_the_python_of_the_pages(checked):
    assert len(checked) == 4
    assert {name: lines for name, lines in checked.items() if lines and name != "mistakes.py"} == {}


def test_a_type_checker_names_a_mistake(checked):
    for line, (mistake, expected) in enumerate(MISTAKES.items(), 2):
        said = [text for text in checked["mistakes.py"] if text.startswith(f"mistakes.py:{line}: error")]
        assert any(expected in text for text in said), mistake

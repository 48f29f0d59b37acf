"""The public names for type checkers and editors, which read the stub and never run the package."""

import json
import re
import subprocess
import sys

from repository import ROOT


def pages():
    """Yield the Python of the pages that show how to use the package, a page in one piece, as a
    reader goes on.
    """
    for page in ("README.md", "docs/index.md"):
        text = (ROOT / page).read_text(encoding="utf-8")
        yield page, "".join(re.findall(r"^```python\n(.*?)^```$", text, re.MULTILINE | re.DOTALL))
    notebook = json.loads((ROOT / "docs/notebooks/explore.ipynb").read_text(encoding="utf-8"))
    yield (
        "explore.ipynb",
        "\n".join("".join(c["source"]) for c in notebook["cells"] if c["cell_type"] == "code"),
    )


def test_strict_type_checker_passes_pages_and_names_a_mistake(tmp_path):
    """Away from the repository's settings, as a user would."""
    files = {re.sub(r"\W", "_", page) + ".py": code for page, code in pages()}
    files["mistake.py"] = "import rockdamp as rd\nrd.Wall(thickness=0.3, hight=4.5)\n"
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="utf-8")
    # A second run finds the libraries in the cache.
    cache = f"--cache-dir={ROOT / '.mypy_cache/pages'}"
    options = ["--strict", "--config-file=", "--hide-error-context", "--no-pretty", cache]
    run = subprocess.run(
        [sys.executable, "-m", "mypy", *options, *files],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    lines = [
        line
        for line in run.stdout.splitlines()
        if ": error:" in line and line.split(":")[0] in files
    ]
    assert lines and all(line.startswith("mistake.py:2:") for line in lines), (
        run.stdout + run.stderr
    )

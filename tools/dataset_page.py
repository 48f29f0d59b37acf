"""Write docs/datasets.md from a build: the variables of every dataset, with their meanings.

`python tools/dataset_page.py` reads the minimal build, which has the same names as the full one.
"""

import re
import sys
from pathlib import Path

import xarray as xr

from rockdamp.constants import STUDIES
from rockdamp.storage.dataset import glossary, variables

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs/datasets.md"
HEAD = """# Datasets

<!-- tools/dataset_page.py writes this page from a build. -->

Every dataset of `results/`, as a full build leaves it. `xarray.open_dataset` opens each file. The
unit 1 means dimensionless. Symbols are the paper's, where it has one. Each file states the values
of the config that it was computed from (attribute `config`) and the version of the code
(`code_version`).
"""
TABLE = """
| name | dimensions | unit | meaning | symbol |
| --- | --- | --- | --- | --- |
"""


def find_datasets(results):
    """Return the paths of the datasets by their kind, in the order of the glossary."""
    kinds = {entry["title"]: kind for kind, entry in glossary()["datasets"].items()}
    paths = {kind: [] for kind in kinds.values()}
    for path in sorted(results.rglob("*.nc")):
        with xr.open_dataset(path) as data:
            paths[kinds[data.attrs["title"]]].append(path)
    return {kind: members for kind, members in paths.items() if members}


def name_file(path, results):
    """Return the name of a dataset's file, with `{study}` or `{number}` for several files."""
    name = path.relative_to(results).as_posix()
    if path.stem in STUDIES and path.parent != results:
        return name.replace(path.stem, "{study}")
    return re.sub(r"-\d+\.nc$", "-{number}.nc", name)


def find_dimensions(paths):
    """Return the dimensions of the variables of a kind; `parameter` is that of a study."""
    dimensions = {}
    for path in paths:
        parameter = STUDIES.get(path.stem)
        with xr.open_dataset(path) as data:
            for name, variable in data.variables.items():
                names = ["parameter" if dim == parameter else dim for dim in variable.dims]
                dimensions.setdefault(name, ", ".join(names))
    return dimensions


def describe_kind(kind, paths, results):
    """Return the section of a kind of dataset."""
    names = dict.fromkeys(f"`results/{name_file(path, results)}`" for path in paths)
    section = f"\n## {', '.join(names)}\n\n{glossary()['datasets'][kind]['title']}.\n"
    if "{study}" in section:
        studies = [f"`{study}` (`{parameter}`)" for study, parameter in STUDIES.items()]
        section += f"\nThe studies, with the parameter that each varies: {', '.join(studies)}.\n"
        section += "The dimension `parameter` stands for the name of that parameter.\n"
    section += TABLE
    dimensions = find_dimensions(paths)
    for name, entry in variables(kind).items():
        if name in dimensions:
            symbol = f"`{entry['symbol']}`" if "symbol" in entry else ""
            meaning = entry["long_name"]
            if "comment" in entry:
                meaning += f" ({entry['comment']})"
            cells = [f"`{name}`", dimensions[name], entry["units"], meaning, symbol]
            row = " | ".join(cell.replace("|", "\\|") for cell in cells)
            section += f"| {row} |\n"
    return section


def make_page(results):
    """Return the text of the page for a folder of results."""
    sections = [
        describe_kind(kind, paths, results) for kind, paths in find_datasets(results).items()
    ]
    return HEAD + "".join(sections)


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "results/minimal"
    PAGE.write_text(make_page(folder), encoding="utf-8")

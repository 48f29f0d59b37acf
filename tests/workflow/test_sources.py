"""The digest of the code: what it counts of a module, and which modules it finds."""

import sys

import pytest
from repository import ROOT

import rockdamp


@pytest.fixture
def sources(monkeypatch, tmp_path):
    """The script, and a package of one's own in place of rockdamp."""
    monkeypatch.syspath_prepend(str(ROOT / "workflow/scripts"))
    sys.modules.pop("sources", None)
    import sources

    (tmp_path / "rockdamp/deep").mkdir(parents=True)
    monkeypatch.setattr(rockdamp, "__file__", str(tmp_path / "rockdamp/__init__.py"))

    def code(**modules):
        for name, text in {
            "deep/__init__": "",
            "deep/leaf": "x = 1\n",
            "errors": "",
            **modules,
        }.items():
            (tmp_path / f"rockdamp/{name}.py").write_text(text, encoding="utf-8")
        sources._read.cache_clear()
        sources._file.cache_clear()
        monkeypatch.setattr(sources, "__file__", str(tmp_path / "sources.py"))
        (tmp_path / "dataset.py").write_text("import sys\n", encoding="utf-8")
        return sources.code("top")

    yield code
    sys.modules.pop("sources", None)


def names(found):
    return [each.split()[0] for each in found]


@pytest.mark.parametrize(
    "statement",
    [
        "from rockdamp.deep.leaf import x",
        "from rockdamp.deep import leaf",
        "import rockdamp.deep.leaf",
        "def f():\n    import rockdamp.deep.leaf as leaf",
    ],
)
def test_every_form_of_import_is_followed(sources, statement):
    assert names(sources(top=statement)) == ["dataset", "deep.leaf", "top"]


@pytest.mark.parametrize(
    "statement", ["from rockdamp import Wall", "import rockdamp", "from .deep import leaf"]
)
def test_an_import_that_hides_its_module_is_refused(sources, statement):
    with pytest.raises(ValueError, match="top.py"):
        sources(top=statement)


def test_libraries_that_are_imported_anywhere_have_their_version_and_plumbing_is_left_out(sources):
    found = names(
        sources(
            top="import rockdamp.deep.leaf\nimport rockdamp.errors",
            **{"deep/leaf": "import numba.core"},
        )
    )
    assert found == ["dataset", "deep.leaf", "top", "numba"]


def test_comments_docstrings_and_layout_do_not_count_and_all_else_does(sources):
    text = "class A:\n    b = 1\n\n    def c(self):\n        return 2\n"
    before = sources(top=text)
    words = text.replace("b = 1", 'b = 1  # b\n    """What b is."""').replace(
        "):\n", '):\n        """Return 2."""\n'
    )
    assert sources(top=f'"""A module."""\n{words}') == before
    assert sources(top=text.replace("2", "3")) != before
    assert sources(top=text, **{"deep/leaf": "x = 2\n"}) == before  # which it does not import

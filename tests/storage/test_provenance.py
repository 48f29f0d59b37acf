"""Which sources a result depends on, and digests of them."""

import ast
import copy
import json
import os
import re
import shutil
import subprocess
import sys
import time

import pytest

from rockdamp.pipeline.tables import STAGES
from rockdamp.storage import glossary, provenance

MODULES = [
    "studies.decays",
    "equivalence.matching",
    "studies.matches",
    "studies.response_lengths",
    "studies.polynomial_fits",
    "studies.mechanism",
    "studies.validation",
    "laboratory.calibration",
    "studies.convergence",
]


@pytest.fixture
def package(tmp_path, monkeypatch):
    """A copy of the package that may be edited, in the place of the real one."""
    copy = tmp_path / "rockdamp"
    shutil.copytree(provenance.ROOT, copy, ignore=shutil.ignore_patterns("__pycache__"))
    monkeypatch.setattr(provenance, "ROOT", copy)
    forget()
    yield copy
    forget()


def modules_of(stage):
    """The modules that count for a stage."""
    left_out = {*provenance.NO_SCIENCE, *stage.sources.without}
    modules = provenance.modules_of(*stage.sources.modules).items()
    return {name: path for name, path in modules if name not in left_out and ".config" not in name}


def forget():
    for cached in (provenance._file_of, provenance._read, provenance.code_version):
        cached.cache_clear()


def write(package, sources):
    for name, text in sources.items():
        path = package / f"{name}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")


@pytest.fixture(scope="module")
def loaded():
    """What an import of each module loads, in one fresh interpreter."""
    # The package's own __init__ is run by any import, and loads what it passes on: an empty one stands for it.
    code = f"""
import importlib, json, sys, types

loaded = {{}}
for name in {[*MODULES, "storage.dataset", "figures"]!r}:
    for old in [old for old in sys.modules if old.partition(".")[0] == "rockdamp"]:
        del sys.modules[old]
    package = sys.modules["rockdamp"] = types.ModuleType("rockdamp")
    package.__path__ = [{str(provenance.ROOT)!r}]
    importlib.import_module(f"rockdamp.{{name}}")
    loaded[name] = [module for module in sys.modules if module.startswith("rockdamp.")]
print(json.dumps(loaded))
"""
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return json.loads(run.stdout)


@pytest.mark.parametrize("module", [*MODULES, "storage.dataset", "figures"])
def test_every_module_that_an_import_loads_is_found(module, loaded):
    assert f"rockdamp.{module}" in loaded[module]
    assert set(loaded[module]) <= set(provenance.modules_of(f"rockdamp.{module}"))


def test_a_stage_depends_on_the_kernels_and_not_on_other_stages():
    modules = provenance.modules_of("rockdamp.studies.decays")
    assert {"rockdamp.mechanics.damping.cdr", "rockdamp.solvers.newmark_kernel"} <= set(modules)
    assert not {"rockdamp", "rockdamp.equivalence.matching", "rockdamp.studies.validation"} & set(modules)
    assert all(path.is_file() and path.suffix == ".py" for path in modules.values())


def test_every_form_of_import_is_followed(package):
    top = """
import json, os.path
import rockdamp.one
from rockdamp import two
from rockdamp.three import name
from . import four
from .five import name
from rockdamp.sub import seven

def late():
    from rockdamp import six
"""
    write(package, {"top": top, "sub/__init__": "from .eight import name", "sub/seven": "from ..nine import name"})
    write(package, dict.fromkeys(["one", "two", "three", "four", "five", "six", "nine", "sub/eight"], "name = 1"))
    found = {name.removeprefix("rockdamp.") for name in provenance.modules_of("rockdamp.top")}
    numbers = {"one", "two", "three", "four", "five", "six", "nine"}
    assert found == {"top", "sub", "sub.seven", "sub.eight", *numbers}


def test_a_name_taken_from_the_packages_face_depends_on_the_face(package):
    write(package, {"__init__": "from rockdamp.mechanics.curve import Curve", "one": "from rockdamp import Curve"})
    assert {"rockdamp", "rockdamp.mechanics.curve"} <= set(provenance.modules_of("rockdamp.one"))


MODULE = """
'''What it is for.'''
from rockdamp.errors import InputError, require
from rockdamp.plausibility import warn

def double(value: float) -> float:
    '''Return twice a value.'''
    require(value > 0, "value", value, allowed="positive")
    if value > 9:
        warn([f"{value} is large"])
    if value > 99:
        raise InputError(f"value is {value}")
    return 2 * value  # twice
"""
SPOKEN = ("What it is for", "Return twice a value", '"positive"', '"value"', "# twice", " is {value}")


@pytest.mark.parametrize("words", SPOKEN)
def test_words_for_people_change_no_version(package, words):
    assert words in MODULE
    write(package, {"doubling": MODULE})
    before = provenance.code_version("rockdamp.doubling")
    forget()
    write(package, {"doubling": MODULE.replace(words, words[:-2] + "s" + words[-2:])})
    assert provenance.code_version("rockdamp.doubling") == before


@pytest.mark.parametrize(
    ("old", "new"), [("2 * value", "3 * value"), ("> 9:", "> 8:"), ("require(value > 0", "require(value > 1")]
)
def test_what_computes_or_decides_changes_the_version(package, old, new):
    write(package, {"doubling": MODULE, "user": "from rockdamp.doubling import double", "other": "VALUE = 1"})
    before = {name: provenance.code_version(f"rockdamp.{name}") for name in ("doubling", "user", "other")}
    forget()
    write(package, {"doubling": MODULE.replace(old, new)})
    changed = {name for name, version in before.items() if provenance.code_version(f"rockdamp.{name}") != version}
    assert changed == {"doubling", "user"}


def test_the_version_does_not_depend_on_how_the_code_is_laid_out(package):
    write(package, {"doubling": "VALUES = (1, 2)\n"})
    before = provenance.code_version("rockdamp.doubling")
    forget()
    write(package, {"doubling": "VALUES = (\n    1,  # one\n    2,\n)\n"})
    assert provenance.code_version("rockdamp.doubling") == before


def test_what_a_left_out_module_imports_counts_and_itself_does_not(package):
    write(package, {"user": "from rockdamp import plausibility", "science": "VALUE = 1"})
    write(package, {"plausibility": "from rockdamp.science import VALUE"})
    before = provenance.code_version("rockdamp.user")
    for name, text, same in (
        ("plausibility", "from rockdamp.science import VALUE as BOUND", True),
        ("science", "VALUE = 2", False),
    ):
        forget()
        write(package, {name: text})
        assert (provenance.code_version("rockdamp.user") == before) == same


def test_modules_that_are_left_out_exist():
    for name in (*provenance.NO_SCIENCE, *provenance.NUMBERS_IN_WORDS):
        assert name in provenance.modules_of(name)


def test_errors_of_what_stages_compute_with_are_made_where_they_are_raised():
    """Elsewhere an edit of their words would run stages again."""
    modules = {name: path for stage in STAGES.values() for name, path in modules_of(stage).items()}
    for name, path in modules.items():
        tree = ast.parse(path.read_text(encoding="utf-8"))
        raised = {id(part) for node in ast.walk(tree) if isinstance(node, ast.Raise) for part in ast.walk(node)}
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and id(node) not in raised:
                assert not re.search(r"(Error|Warning)$", ast.unparse(node.func)), (name, node.lineno)


def test_the_code_version_follows_an_edit_of_a_data_file(package):
    write(package, {"reader": "NAME = 'numbers.csv'"})
    (package / "numbers.csv").write_text("1", encoding="utf-8")
    before = provenance.code_version("rockdamp.reader")
    forget()
    (package / "numbers.csv").write_text("2", encoding="utf-8")
    assert provenance.code_version("rockdamp.reader") != before


def test_the_version_of_a_dataset_follows_what_the_glossary_says_of_its_own_names(monkeypatch):
    kinds = "decay", "convergence"
    before = [provenance.code_version("rockdamp.studies", dataset=kind) for kind in kinds]
    forget()
    edited = copy.deepcopy(glossary.read())
    edited["names"]["velocity"]["long_name"] += ", taken with its sign"
    monkeypatch.setattr(glossary, "read", lambda: edited)
    after = [provenance.code_version("rockdamp.studies", dataset=kind) for kind in kinds]
    assert [new == old for new, old in zip(after, before, strict=True)] == [False, True]


def test_an_edit_since_a_moment_is_noticed_whatever_its_date(package):
    moment = time.time() + 1
    assert not provenance.edited_since(moment)
    time.sleep(1.1)
    os.utime(package / "vocabulary.py", (0, 0))
    assert provenance.edited_since(moment)


def test_the_config_digest_is_that_of_canonical_json():
    # sha256 of {"a":{"b":[1,2.5],"c":"é"},"z":null}, by sha256sum
    expected = "b79d7a9446bce2f1b4c18bf0e2bc25bc336b3ca4c0e6cf98944c4de02dfef862"
    assert provenance.config_digest({"z": None, "a": {"c": "é", "b": [1, 2.5]}}) == expected
    assert provenance.config_digest({"a": {"b": [1, 2.5], "c": "é"}, "z": None}) == expected
    assert provenance.config_digest({"a": {"b": [2.5, 1], "c": "é"}, "z": None}) != expected

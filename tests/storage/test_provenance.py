"""Which sources a result depends on, and digests of them."""

import json
import shutil
import subprocess
import sys

import pytest

from rockdamp.storage import provenance

STAGES = [
    "studies.decays",
    "equivalence.matching",
    "studies.matches",
    "studies.response_lengths",
    "studies.polynomial_fits",
    "studies.damping_force",
    "studies.force_curves",
    "studies.validation",
    "laboratory.stages",
    "studies.accuracy.convergence",
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


def forget():
    for cached in (provenance._file_of, provenance._text, provenance._imports, provenance._data_files):
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
for name in {[*STAGES, "storage.dataset", "figures"]!r}:
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


@pytest.mark.parametrize("module", [*STAGES, "storage.dataset", "figures"])
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


def test_the_code_version_follows_an_edit_of_what_is_imported_and_of_nothing_else(package):
    before = {name: provenance.code_version(f"rockdamp.{name}") for name in ("studies.decays", "mechanics.wall")}
    with (package / "solvers/newmark.py").open("a", encoding="utf-8") as source:
        source.write("# edited\n")
    after = {name: provenance.code_version(f"rockdamp.{name}") for name in before}
    assert before["studies.decays"] != after["studies.decays"]
    assert before["mechanics.wall"] == after["mechanics.wall"]


def test_the_code_version_follows_an_edit_of_a_data_file(package):
    names = "rockdamp.storage.dataset", "rockdamp.mechanics.curve"
    before = [provenance.code_version(name) for name in names]
    (package / "storage/variables.yaml").write_text("common: {}\ndatasets: {}\n", encoding="utf-8")
    assert provenance.code_version(names[0]) != before[0]
    assert provenance.code_version(names[1]) == before[1]


def test_the_config_digest_is_that_of_canonical_json():
    # sha256 of {"a":{"b":[1,2.5],"c":"é"},"z":null}, by sha256sum
    expected = "b79d7a9446bce2f1b4c18bf0e2bc25bc336b3ca4c0e6cf98944c4de02dfef862"
    assert provenance.config_digest({"z": None, "a": {"c": "é", "b": [1, 2.5]}}) == expected
    assert provenance.config_digest({"a": {"b": [1, 2.5], "c": "é"}, "z": None}) == expected
    assert provenance.config_digest({"a": {"b": [2.5, 1], "c": "é"}, "z": None}) != expected


def test_a_part_of_the_config_keeps_its_nesting_and_nothing_else():
    curve = {"strength_ratio": 0.85, "softening": "steeper", "ultimate_displacement_ratio": 1.0}
    config = {"release_amplitude": 0.5, "curve": curve, "matching": {"response_length": 8, "scan": {"points": 3}}}
    part = provenance.subset(config, "release_amplitude", "curve.strength_ratio", "matching.scan", "curve.softening")
    assert part == {
        "release_amplitude": 0.5,
        "curve": {"strength_ratio": 0.85, "softening": "steeper"},
        "matching": {"scan": {"points": 3}},
    }

"""Docstrings: their examples run, and those of public names describe parameters and units."""

import doctest
import inspect
import re
from functools import cached_property
from importlib import import_module
from pkgutil import walk_packages

import pytest
from page_blocks import Checker

import rockdamp as rd

MODULES = [
    module.name
    for module in walk_packages(rd.__path__, "rockdamp.")
    if not module.name.endswith(".__main__")
]
PUBLIC = {name: getattr(rd, name) for name in rd.__all__}
CLASSES = {name: value for name, value in PUBLIC.items() if inspect.isclass(value)}


def list_members():
    """Return the public methods and properties of the public classes, by their full names."""
    members = {}
    for class_name, public_class in CLASSES.items():
        for name, member in inspect.getmembers_static(public_class):
            if not name.startswith("_"):
                members[f"{class_name}.{name}"] = getattr(member, "__func__", member)
    return members


def list_getters(members):
    """Return the functions behind properties."""
    getters = {}
    for name, member in members.items():
        if isinstance(member, property):
            getters[name] = member.fget
        elif isinstance(member, cached_property):
            getters[name] = member.func
    return getters


MEMBERS = list_members()
FUNCTIONS = {
    name: value
    for name, value in (PUBLIC | MEMBERS).items()
    if inspect.isfunction(value) and value.__module__.startswith("rockdamp")
}
NUMBERS = {
    name: getter
    for name, getter in list_getters(MEMBERS).items()
    if inspect.signature(getter).return_annotation in ("Array", "Quantity", "float")
}


def find_undescribed(names, text):
    return [name for name in names if not re.search(rf"\b{name}\b", text)]


@pytest.mark.parametrize("name", ["rockdamp", *MODULES])
def test_examples_of_a_module_print_their_values(name):
    runner = doctest.DocTestRunner(Checker(), optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in doctest.DocTestFinder().find(import_module(name)):
        assert runner.run(example).failed == 0


@pytest.mark.parametrize("name", [name for name in PUBLIC if name in FUNCTIONS])
def test_public_function_has_an_example(name):
    assert ">>> " in inspect.getdoc(FUNCTIONS[name])


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_parameter_is_described(name):
    text = inspect.getdoc(FUNCTIONS[name])
    parameters = inspect.signature(FUNCTIONS[name]).parameters.keys() - {"self", "cls"}
    assert find_undescribed(parameters, text) == []


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_is_described(name):
    """The docstrings of the class, of its bases and of their modules count."""
    bases = [base for base in CLASSES[name].__mro__ if base.__module__.startswith("rockdamp")]
    text = "\n".join(f"{inspect.getdoc(base)}\n{inspect.getmodule(base).__doc__}" for base in bases)
    for base in bases:
        fields = [field for field in base.__annotations__ if not field.startswith("_")]
        assert find_undescribed(fields, text) == []


@pytest.mark.parametrize("name", NUMBERS)
def test_numeric_property_states_its_unit(name):
    summary = inspect.getdoc(NUMBERS[name]).split("\n\n")[0]
    assert re.search(r"\[(?:-|[\w -]+)\]", summary)

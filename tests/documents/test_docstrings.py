"""Docstrings: their examples run, and those of public names describe parameters and units."""

import doctest
import inspect
import re
from functools import cached_property
from importlib import import_module
from pkgutil import walk_packages

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


def test_examples_of_modules_print_their_values():
    runner = doctest.DocTestRunner(Checker(), optionflags=doctest.NORMALIZE_WHITESPACE)
    for name in ["rockdamp", *MODULES]:
        for example in doctest.DocTestFinder().find(import_module(name)):
            assert runner.run(example).failed == 0, example.name


def test_public_functions_have_an_example():
    functions = [name for name in PUBLIC if name in FUNCTIONS]
    assert [name for name in functions if ">>> " not in inspect.getdoc(FUNCTIONS[name])] == []


def test_every_parameter_is_described():
    for name, function in FUNCTIONS.items():
        parameters = inspect.signature(function).parameters.keys() - {"self", "cls"}
        assert find_undescribed(parameters, inspect.getdoc(function)) == [], name


def test_every_field_is_described():
    """The docstrings of the class, of its bases and of their modules count."""
    for public_class in CLASSES.values():
        bases = [base for base in public_class.__mro__ if base.__module__.startswith("rockdamp")]
        texts = [f"{inspect.getdoc(base)}\n{inspect.getmodule(base).__doc__}" for base in bases]
        for base in bases:
            fields = [field for field in base.__annotations__ if not field.startswith("_")]
            assert find_undescribed(fields, "\n".join(texts)) == [], public_class


def test_numeric_properties_state_their_unit():
    for name, getter in NUMBERS.items():
        summary = inspect.getdoc(getter).split("\n\n")[0]
        assert re.search(r"\[(?:-|[\w -]+)\]", summary), name

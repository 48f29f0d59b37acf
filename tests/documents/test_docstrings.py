"""Docstrings: their examples run; the public ones name every argument and field, and each number
its unit.
"""

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
CLASSES = {name: thing for name, thing in PUBLIC.items() if inspect.isclass(thing)}
MEMBERS = {
    f"{name}.{attribute}": getattr(value, "__func__", value)
    for name, owner in CLASSES.items()
    for attribute, value in inspect.getmembers_static(owner)
    if not attribute.startswith("_")
}
FUNCTIONS = {
    name: thing
    for name, thing in (PUBLIC | MEMBERS).items()
    if inspect.isfunction(thing) and thing.__module__.startswith("rockdamp")
}
PROPERTIES = {name: member.fget for name, member in MEMBERS.items() if isinstance(member, property)}
PROPERTIES |= {
    name: member.func for name, member in MEMBERS.items() if isinstance(member, cached_property)
}


@pytest.mark.parametrize("name", ["rockdamp", *MODULES])
def test_the_examples_of_a_module_print_what_they_say(name):
    runner = doctest.DocTestRunner(Checker(), optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in doctest.DocTestFinder().find(import_module(name)):
        assert runner.run(example).failed == 0


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_of_a_public_function_is_described(name):
    text = inspect.getdoc(FUNCTIONS[name])
    assert name not in PUBLIC or ">>> " in text
    arguments = set(inspect.signature(FUNCTIONS[name]).parameters) - {"self", "cls"}
    if "parameters are those of `" not in text:
        assert {
            argument for argument in arguments if not re.search(rf"\b{argument}\b", text)
        } == set()


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_of_a_public_class_is_described(name):
    """In the docstring of the class or of one that it is made from, or at the head of the module."""
    bases = [base for base in CLASSES[name].__mro__ if base.__module__.startswith("rockdamp")]
    fields = {
        field for base in bases for field in base.__annotations__ if not field.startswith("_")
    }
    text = "\n".join(f"{inspect.getdoc(base)}\n{inspect.getmodule(base).__doc__}" for base in bases)
    assert {field for field in fields if not re.search(rf"\b{field}\b", text)} == set()


@pytest.mark.parametrize("name", PROPERTIES)
def test_a_property_that_is_a_number_states_its_unit(name):
    if inspect.signature(PROPERTIES[name]).return_annotation in ("Array", "Quantity", "float"):
        assert re.search(r"\[(?:-|[\w -]+)\]", inspect.getdoc(PROPERTIES[name]).split("\n\n")[0])

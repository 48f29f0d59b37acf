"""Docstrings: their examples run; the public ones describe every argument and field, with its unit."""

import doctest
import inspect
import re
from functools import cached_property
from importlib import import_module
from pkgutil import walk_packages

import pytest
from page_blocks import Checker

import rockdamp as rd

MODULES = ["rockdamp", *sorted(module.name for module in walk_packages(rd.__path__, "rockdamp."))]
MODULES = [name for name in MODULES if not name.endswith(".__main__")]  # which would run
PUBLIC = {name: getattr(rd, name) for name in rd.__all__}
CLASSES = {name: thing for name, thing in PUBLIC.items() if inspect.isclass(thing)}


def own_classes(owner):
    """Return a class and those of the package that it is made from, which come first."""
    return [base for base in reversed(owner.__mro__) if base.__module__.startswith("rockdamp")]


MEMBERS = {
    f"{name}.{attribute}": value
    for name, owner in CLASSES.items()
    for base in own_classes(owner)
    for attribute, value in vars(base).items()
    if not attribute.startswith(("_", "unchecked_"))  # the unchecked twin of a method takes the same arguments
}
PROPERTIES = {name: member.fget for name, member in MEMBERS.items() if isinstance(member, property)}
PROPERTIES |= {name: member.func for name, member in MEMBERS.items() if isinstance(member, cached_property)}
FUNCTIONS = {
    name: getattr(thing, "__func__", thing)
    for name, thing in (PUBLIC | MEMBERS).items()
    if inspect.isfunction(getattr(thing, "__func__", thing))
}


def parameters(docstring):
    """Return what the section of parameters lists: by name, what stands behind its colon."""
    section = re.search(r"^Parameters\n-+\n(.*?)(?=^\w+\n-+\n|\Z)", docstring, re.MULTILINE | re.DOTALL)
    heads = [line.partition(" : ") for line in re.findall(r"^\S.*$", section[1] if section else "", re.MULTILINE)]
    return {name.strip(" *"): kind for names, _, kind in heads for name in names.split(",")}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_every_argument_of_a_public_function_is_described(name):
    """In the list of parameters, or, where there are few, in the sentence."""
    arguments = set(inspect.signature(FUNCTIONS[name]).parameters) - {"self", "cls"}
    text = inspect.getdoc(FUNCTIONS[name])
    assert set(parameters(text)) <= arguments
    if "parameters are those of `" not in text:
        assert {argument for argument in arguments if not re.search(rf"\b{argument}\b", text)} == set()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_an_argument_that_is_listed_has_a_type(name):
    classes = {"record": "Record", "wall": "Wall", "curve": "TrilinearCurve"}  # named after their type
    kinds = parameters(inspect.getdoc(FUNCTIONS[name]))
    assert {argument for argument, kind in kinds.items() if not kind} <= set(classes)


@pytest.mark.parametrize("name", CLASSES)
def test_every_field_of_a_public_class_is_described(name):
    """In the docstring of the class, or at the head of its module."""
    bases = own_classes(CLASSES[name])
    fields = {field for base in bases for field in base.__annotations__ if not field.startswith("_")}
    text = "\n".join(f"{inspect.getdoc(base)}\n{inspect.getmodule(base).__doc__}" for base in bases)
    assert {field for field in fields if not re.search(rf"\b{field}\b", text)} == set()


@pytest.mark.parametrize("name", PROPERTIES)
def test_a_property_that_is_a_number_states_its_unit(name):
    kind = inspect.signature(PROPERTIES[name]).return_annotation
    if kind in ("Array", "Quantity", "float"):
        assert re.search(r"\[(?:-|[\w -]+)\]", inspect.getdoc(PROPERTIES[name]).split("\n\n")[0])
    else:
        assert kind in ("bool", "str", "tuple[int, ...]", "dict[str, Quantity]", "Record", "Modes")


@pytest.mark.no_cover
@pytest.mark.parametrize("name", MODULES)
def test_the_examples_of_a_module_print_what_they_say(name):
    runner = doctest.DocTestRunner(Checker(), optionflags=doctest.NORMALIZE_WHITESPACE)
    for example in doctest.DocTestFinder().find(import_module(name)):
        assert runner.run(example).failed == 0


@pytest.mark.parametrize("name", [name for name, thing in PUBLIC.items() if inspect.isfunction(thing)])
def test_every_public_function_has_an_example(name):
    assert doctest.DocTestFinder(recurse=False).find(PUBLIC[name], name)[0].examples

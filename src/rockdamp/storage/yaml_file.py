"""YAML 1.2 with its core schema, by PyYAML's compiled parser where there is one: every job reads long documents.

PyYAML by itself reads YAML 1.1, in which 1:30 is 90, 010 is 8 and 1e3 is text, and of two keys of one name it keeps
the last. Here they are text, 10, a number, and an error.
"""

from __future__ import annotations

import re
from typing import Any

import yaml

try:
    from yaml import CSafeLoader as _Base
except ImportError:  # a PyYAML built without libyaml
    from yaml import SafeLoader as _Base  # type: ignore[assignment]

MOST_VALUES = 1_000_000  # of a document, with each alias counted as what it stands for
MOST_DIGITS = 400  # of a whole number; longer ones are beyond every other number too
NUMBERS = {  # the core schema of YAML 1.2: tag, form, first letters
    "null": (r"(?:~|null|Null|NULL|)", ["~", "n", "N", ""]),
    "bool": (r"(?:true|True|TRUE|false|False|FALSE)", list("tTfF")),
    "int": (r"(?:[-+]?[0-9]+|0o[0-7]+|0x[0-9a-fA-F]+)", list("-+0123456789")),
    "float": (
        r"(?:[-+]?(?:\.[0-9]+|[0-9]+(?:\.[0-9]*)?)(?:[eE][-+]?[0-9]+)?|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN))",
        list("-+.0123456789"),
    ),
    "merge": (r"<<", ["<"]),
}
MOST_DEPTH = 100  # of brackets, which a parser without such a bound follows until its stack is full
_INDENTED = re.compile(r"^[ ?:-]{200}", re.MULTILINE)
_ALIAS = re.compile(r"(?:^|[\s,:\[{-])\*")


class Loader(_Base):
    """The loader; its numbers are those of YAML 1.2."""

    yaml_implicit_resolvers: dict[str, Any] = {}

    def __init__(self, text: str) -> None:
        super().__init__(text)
        self.compared: set[int] = set()  # mappings, which hold the keys of `<<` too once it was put in place

    def flatten_mapping(self, node: yaml.MappingNode) -> None:
        """Put the keys of `<<` in place, after those that stand there were compared."""
        if id(node) not in self.compared:
            self.compared.add(id(node))
            _refuse_repeated_keys(node)
        super().flatten_mapping(node)


def _whole(loader: Loader, node: yaml.ScalarNode) -> int | float:
    text = loader.construct_scalar(node)
    if len(text) > MOST_DIGITS:
        return float("-inf" if text.startswith("-") else "inf")
    return int(text, 0) if text[:2] in ("0o", "0x") else int(text)


def _real(loader: Loader, node: yaml.ScalarNode) -> float:
    return float(loader.construct_scalar(node).lower().replace(".inf", "inf").replace(".nan", "nan"))


for _tag, (_form, _letters) in NUMBERS.items():
    Loader.add_implicit_resolver(f"tag:yaml.org,2002:{_tag}", re.compile(f"{_form}\\Z"), _letters)
Loader.add_constructor("tag:yaml.org,2002:int", _whole)
Loader.add_constructor("tag:yaml.org,2002:float", _real)


def load(text: str) -> Any:
    """Return what a YAML document holds.

    Raises
    ------
    yaml.YAMLError
        If it is none, a mapping has a key twice, or it is nested too deep or, with its aliases, too large.
    """
    if _depth(text) > MOST_DEPTH or _INDENTED.search(text):
        raise yaml.YAMLError("it is nested too deep")
    loader = Loader(text)
    try:
        node = loader.get_single_node()
        if node is None:
            return None
        if _ALIAS.search(text):
            _size(node, {}, set())
        return loader.construct_document(node)
    except (ValueError, OverflowError) as error:  # what is tagged as a number and is none, a letter that is none
        raise yaml.YAMLError(str(error)) from None
    finally:
        loader.dispose()


def _depth(text: str) -> int:
    """How deep the brackets of a text are nested."""
    depth = deepest = 0
    for bracket in re.findall(r"[\[\]{}]", text):
        depth += 1 if bracket in "[{" else -1
        deepest = max(deepest, depth)
    return deepest


def _refuse_repeated_keys(node: yaml.MappingNode) -> None:
    names = [key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
    if len(set(names)) == len(names):
        return
    lines: dict[tuple[str, str], int] = {}
    for key, _ in node.value:
        if isinstance(key, yaml.ScalarNode):
            first = lines.get((key.tag, key.value))
            if first is not None:
                text = f"key {key.value!r} stands there more than once, first on line {first}"
                raise yaml.constructor.ConstructorError(None, None, text, key.start_mark)
            lines[key.tag, key.value] = key.start_mark.line + 1


def _size(node: yaml.Node, sizes: dict[int, int], above: set[int]) -> int:
    """Return how many values a node has, each alias counted as what it stands for."""
    if id(node) in above:
        raise yaml.constructor.ConstructorError(None, None, "an alias stands within what it names", node.start_mark)
    if id(node) in sizes:
        return sizes[id(node)]
    size = 1
    if not isinstance(node, yaml.ScalarNode):
        pairs = isinstance(node, yaml.MappingNode)
        parts = [part for pair in node.value for part in pair] if pairs else node.value
        above.add(id(node))
        size += sum(_size(part, sizes, above) for part in parts)
        above.remove(id(node))
    if size > MOST_VALUES:
        text = f"its aliases stand for more than {MOST_VALUES} values"
        raise yaml.constructor.ConstructorError(None, None, text, node.start_mark)
    sizes[id(node)] = size
    return size

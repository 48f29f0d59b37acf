"""The directive `config-keys`: a table for each section of the config, from its model and the default values."""

from pathlib import Path

import yaml
from sphinx.util.docutils import SphinxDirective

from rockdamp.config import Config

ROOT = Path(__file__).resolve().parents[2]
MODEL = ROOT / "src/rockdamp/config.py"
DEFAULT = ROOT / "config/default.yaml"
BOUNDS = {"exclusiveMinimum": ">", "minimum": "≥", "exclusiveMaximum": "<", "maximum": "≤", "multipleOf": "multiple of"}


def resolved(entry, schema):
    """Follow the reference of an entry, also of a section that may be null; its own words come first."""
    options = entry.get("anyOf", [])
    if {"type": "null"} in options:
        entry = {**options[0], **{key: value for key, value in entry.items() if key != "anyOf"}}
    if "$ref" in entry:
        return {**schema["$defs"][entry["$ref"].rpartition("/")[2]], **entry}
    return entry


def allowed(entry, schema):
    """What a key accepts, in few words."""
    entry = resolved(entry, schema)
    if "anyOf" in entry:
        return " or ".join(allowed(option, schema) for option in entry["anyOf"])
    if "const" in entry:
        return f"`{entry['const']}`"
    if "enum" in entry:
        return ", ".join(f"`{value}`" for value in entry["enum"])
    exclusive = {key.removeprefix("exclusive").lower() for key in entry if key.startswith("exclusive")}
    bounds = ", ".join(f"{sign} {entry[key]:.15g}" for key, sign in BOUNDS.items() if key in entry.keys() - exclusive)
    if entry.get("type") == "array":
        items = allowed(entry["items"], schema) if "items" in entry else ""
        return "list" + (f" of {items}" if items else "")
    return f"{entry.get('type', 'any')} {bounds}".strip()


def keys(entry, schema, values, path=()):
    """Yield (path, entry, value) of every key that is no section."""
    for name, own in resolved(entry, schema).get("properties", {}).items():
        found, value = resolved(own, schema), values.get(name) if isinstance(values, dict) else None
        if "properties" in found:
            yield from keys(found, schema, value, (*path, name))
        else:
            yield (*path, name), found, value


def cell(text):
    return " ".join(str(text).split()).replace("|", "\\|")


def lines(schema, defaults):
    for section, entry in schema["properties"].items():
        found = resolved(entry, schema)
        yield from (f"## `{section}`", "", cell(entry.get("description", "")), "")
        rows = [((), found, defaults.get(section))]
        if "properties" in found:
            rows = list(keys(found, schema, defaults.get(section)))
        yield from ("| key | accepts | default | meaning |", "|---|---|---|---|")
        for path, own, value in rows:
            name = ".".join((section, *path))
            meaning = cell(own.get("description", "")) if path else "as above"
            default = "" if value is None else f"`{cell(value)}`"
            yield f"| `{name}` | {cell(allowed(own, schema))} | {default} | {meaning} |"
        yield ""


class ConfigKeys(SphinxDirective):
    def run(self):
        for path in (MODEL, DEFAULT):
            self.env.note_dependency(str(path))
        schema, defaults = Config.model_json_schema(), yaml.safe_load(DEFAULT.read_text(encoding="utf-8"))
        return self.parse_text_to_nodes("\n".join(lines(schema, defaults)), allow_section_headings=True)


def setup(app):
    app.add_directive("config-keys", ConfigKeys)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

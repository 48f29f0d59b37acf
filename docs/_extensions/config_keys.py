"""The directive `config-keys`: a table for each section of the config, from its JSON schema and the
default values.
"""

from pathlib import Path

import yaml
from sphinx.util.docutils import SphinxDirective

from rockdamp.config import Config

ROOT = Path(__file__).resolve().parents[2]
BOUNDS = {
    "exclusiveMinimum": "> {:.15g}",
    "minimum": "≥ {:.15g}",
    "exclusiveMaximum": "< {:.15g}",
    "maximum": "≤ {:.15g}",
}


def resolve(entry, schema):
    """Follow the reference of an entry, also of a section that may be null; its own description
    comes first.
    """
    if {"type": "null"} in entry.get("anyOf", []):
        entry = entry["anyOf"][0] | {key: value for key, value in entry.items() if key != "anyOf"}
    return schema["$defs"][entry["$ref"].rpartition("/")[2]] | entry if "$ref" in entry else entry


def describe_type(entry, schema):
    """Say in few words what a key accepts."""
    entry = resolve(entry, schema)
    if "anyOf" in entry:
        return " or ".join(describe_type(option, schema) for option in entry["anyOf"])
    if values := entry.get("enum") or [entry[key] for key in ("const",) if key in entry]:
        return ", ".join(f"`{value}`" for value in values)
    if entry.get("type") == "array":
        return f"list of {describe_type(entry.get('items', {}), schema)}"
    return " ".join(
        [
            entry.get("type", "any"),
            *(text.format(entry[key]) for key, text in BOUNDS.items() if key in entry),
        ]
    )


def find_rows(name, entry, schema, value):
    """Yield the cells of every key that is no section."""
    entry = resolve(entry, schema)
    for key, child in entry.get("properties", {}).items():
        yield from find_rows(
            f"{name}.{key}", child, schema, value.get(key) if isinstance(value, dict) else None
        )
    if "properties" not in entry:
        default = "" if value is None else f"`{value}`"
        yield f"`{name}`", describe_type(entry, schema), default, entry.get("description", "")


class ConfigKeys(SphinxDirective):
    def run(self):
        schema = Config.model_json_schema()
        defaults = yaml.safe_load((ROOT / "config/default.yaml").read_text(encoding="utf-8"))
        lines = []
        for name, entry in schema["properties"].items():
            lines += [f"## `{name}`", "", resolve(entry, schema).get("description", ""), ""]
            lines += ["| key | accepts | default | meaning |", "|---|---|---|---|"]
            for row in find_rows(name, entry, schema, defaults.get(name)):
                lines.append(
                    "| "
                    + " | ".join(" ".join(cell.split()).replace("|", "\\|") for cell in row)
                    + " |"
                )
            lines.append("")
        return self.parse_text_to_nodes("\n".join(lines), allow_section_headings=True)


def setup(app):
    app.add_directive("config-keys", ConfigKeys)
    return {"parallel_read_safe": True, "parallel_write_safe": True}

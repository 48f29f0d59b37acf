"""Draw the graph of the rules into README.md, from what snakemake says of the workflow: `make rulegraph`.

Mermaid, which hosting sites draw by themselves. Figures of the same datasets share a node, and an arrow that a longer
way implies is left out.
"""

import re
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
README = ROOT / "README.md"
START, END = "<!-- make rulegraph -->\n", "<!-- end -->\n"

Graph = dict[str, set[str]]  # what each rule needs


def ask(folder: Path = ROOT) -> Graph:
    """Return the rules of the workflow, without `all`."""
    command = [sys.executable, "-m", "snakemake", "--rulegraph", "mermaid-js", "--quiet"]
    text = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    names = dict(re.findall(r"^\s*(id\d+)\[(\w+)", text, flags=re.MULTILINE))
    needs: Graph = {name: set() for name in names.values()}
    for before, after in re.findall(r"^\s*(id\d+) --> (id\d+)$", text, flags=re.MULTILINE):
        needs[names[after]].add(names[before])
    needs.pop("all")
    return needs


def grouped(needs: Graph) -> Graph:
    """Put figures that need the same into one node."""
    groups: dict[frozenset[str], list[str]] = {}
    for name in needs:
        if name.startswith("fig"):
            groups.setdefault(frozenset(needs[name]), []).append(name)
    node = {name: "<br>".join(group) for group in groups.values() for name in group}
    return {node.get(name, name): {node.get(need, need) for need in needs[name]} for name in needs}


def above(needs: Graph, name: str) -> set[str]:
    """Return everything that a rule needs, directly or not."""
    return set().union(*({need} | above(needs, need) for need in needs[name]))


def reduced(needs: Graph) -> Graph:
    """Leave out what a rule needs by way of another."""
    return {
        name: {need for need in own if not any(need in above(needs, other) for other in own)}
        for name, own in needs.items()
    }


def drawn(needs: Graph) -> str:
    """Return the block for README, the same for the same graph."""
    needs = reduced(grouped(needs))
    names = sorted(needs, key=lambda name: (len(above(needs, name)), name))
    lines = [f'    {number}["{name}"]' for number, name in enumerate(names)]
    for after, name in enumerate(names):
        lines += [f"    {names.index(need)} --> {after}" for need in sorted(needs[name])]
    return "\n".join(["```mermaid", "flowchart LR", *lines, "```", ""])


def replaced(text: str, block: str) -> str:
    """Return README with the block between its marks."""
    before, start, rest = text.partition(START)
    _, end, after = rest.partition(END)
    if not (start and end):
        raise SystemExit(f"README.md has no place for the graph, between {START.strip()} and {END.strip()}")
    return f"{before}{start}{block}{end}{after}"


if __name__ == "__main__":
    README.write_text(replaced(README.read_text(encoding="utf-8"), drawn(ask())), encoding="utf-8")

"""Draw the graph of the rules into docs/figures/rules.svg, each time that the documents are built.

Snakemake says which rule needs which. From left to right, each rule stands in the column after the last that it needs.
Figures of the same datasets share a box. An arrow that a longer way implies is left out, and so are the rules that
gather what is there: `all`, `report`, `paper` and `checksums`.
"""

import re
import subprocess
import sys
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import isotonic_regression

ROOT = Path(__file__).resolve().parents[2]
PICTURE = ROOT / "docs/figures/rules.svg"
GATHER = ("all", "report", "paper", "paper_page", "checksums")

# Lengths in pixels: a line and a letter of the text, its distance to the border, and what lies between boxes.
LINE, LETTER, PADDING, ROW_GAP, COLUMN_GAP, MARGIN = 16, 6.9, 7, 8, 30, 6
INK, QUIET, FIGURE, RULE = "#1A1A1A", "#6E6E6E", "#DCEBF5", "#F4F4F4"
SWEEPS = 24

Graph = dict[str, set[str]]  # what each rule needs
Point = tuple[str, int]  # a rule's name and a column: its box, or where arrows from it pass a later column


def ask(folder: Path = ROOT) -> Graph:
    """Return the rules of the workflow, without those that gather."""
    command = [sys.executable, "-m", "snakemake", "--rulegraph", "mermaid-js", "--quiet"]
    text = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stdout
    names = dict(re.findall(r"^\s*(id\d+)\[(\w+)", text, flags=re.MULTILINE))
    needs: Graph = {name: set() for name in names.values()}
    for before, after in re.findall(r"^\s*(id\d+) --> (id\d+)$", text, flags=re.MULTILINE):
        needs[names[after]].add(names[before])
    return {name: own for name, own in needs.items() if name not in GATHER}


def grouped(needs: Graph) -> Graph:
    """Put figures that need the same into one box, a name a line."""
    groups: dict[frozenset[str], list[str]] = {}
    for name in sorted(needs):
        if name.startswith("fig"):
            groups.setdefault(frozenset(needs[name]), []).append(name)
    box = {name: "\n".join(group) for group in groups.values() for name in group}
    return {box.get(name, name): set(own) for name, own in needs.items()}


def above(needs: Graph, name: str) -> set[str]:
    """Return everything that a rule needs, directly or not."""
    return set().union(*({need} | above(needs, need) for need in needs[name]))


def reduced(needs: Graph) -> Graph:
    """Leave out what a rule needs by way of another."""
    return {
        name: {need for need in own if not any(need in above(needs, other) for other in own)}
        for name, own in needs.items()
    }


def parted(needs: Graph) -> list[Graph]:
    """Return the parts that no arrow joins, the largest first."""
    parts: list[set[str]] = []
    for name in needs:
        joined = {name} | needs[name]
        apart = [part for part in parts if not part & joined]
        parts = [*apart, joined.union(*(part for part in parts if part & joined))]
    return [{name: needs[name] for name in part} for part in sorted(parts, key=lambda part: (-len(part), min(part)))]


class Layout:
    """Where the boxes of a part stand and its arrows pass: in an order in which few cross, and as short as can be."""

    def __init__(self, needs: Graph) -> None:
        self.column: dict[str, int] = {}
        for name in sorted(needs, key=lambda name: (len(above(needs, name)), name)):
            self.column[name] = 1 + max((self.column[need] for need in needs[name]), default=-1)
        self.arrows: list[list[Point]] = [
            [*((need, at) for at in range(self.column[need], self.column[name])), (name, self.column[name])]
            for name in sorted(needs)
            for need in sorted(needs[name])
        ]
        points = {*self.column.items(), *(point for arrow in self.arrows for point in arrow)}
        self.columns = [sorted(p for p in points if p[1] == at) for at in range(1 + max(self.column.values()))]
        self.steps = sorted({step for arrow in self.arrows for step in pairwise(arrow)})
        self.beside: dict[Point, list[Point]] = {point: [] for point in points}
        for one, other in self.steps:
            self.beside[one].append(other)
            self.beside[other].append(one)
        self._order()
        middle = self._place()
        top = min(y - self.height(point) / 2 for point, y in middle.items())
        self.middle = {point: y - top for point, y in middle.items()}  # from the part's top
        self.depth = max(y + self.height(point) / 2 for point, y in self.middle.items())

    def height(self, point: Point) -> float:
        """Height of a box, or of the way of an arrow. [pixels]"""
        return (point[0].count("\n") + 1) * LINE + 8 if self.column[point[0]] == point[1] else LINE / 2

    def _order(self) -> None:
        """Sort each column by the mean row of what its points are joined to, and keep the best of many rounds."""
        best = [list(column) for column in self.columns]
        for sweep in range(SWEEPS):
            for column in self.columns if sweep % 2 else reversed(self.columns):
                row = self._rows()
                mean = {p: float(np.mean([row[q] for q in self.beside[p]] or [np.inf])) for p in column}
                column.sort(key=lambda point, mean=mean: (mean[point], point))
            if self._crossings(self.columns) < self._crossings(best):
                best = [list(column) for column in self.columns]
        self.columns = best

    def _rows(self) -> dict[Point, float]:
        return {point: row / len(column) for column in self.columns for row, point in enumerate(column)}

    def _crossings(self, columns: list[list[Point]]) -> int:
        row = {point: row for column in columns for row, point in enumerate(column)}
        return sum(
            (row[a] - row[c]) * (row[b] - row[d]) < 0 for (a, b), (c, d) in combinations(self.steps, 2) if a[1] == c[1]
        )

    def _place(self) -> dict[Point, float]:
        """Heights of the middles: each near the mean of its neighbours', as far as the boxes leave room."""
        middle: dict[Point, float] = {}
        for column in self.columns:
            ends = np.cumsum([self.height(point) + ROW_GAP for point in column])
            middle |= {p: float(end) for p, end in zip(column, ends - ends[-1] / 2, strict=True)}
        for sweep in range(SWEEPS):
            for column in self.columns if sweep % 2 else reversed(self.columns):
                heights = np.array([self.height(point) for point in column])
                apart = np.concatenate([[0.0], np.cumsum((heights[1:] + heights[:-1]) / 2 + ROW_GAP)])
                wanted = np.array([np.mean([middle[q] for q in self.beside[p]] or [middle[p]]) for p in column])
                placed = isotonic_regression(wanted - apart).x + apart
                middle |= {point: float(y) for point, y in zip(column, placed, strict=True)}
        return middle


def drawn(needs: Graph) -> str:
    """Return the picture as SVG, the same for the same graph."""
    layouts = [Layout(part) for part in parted(reduced(grouped(needs)))]
    longest = [0] * max(len(layout.columns) for layout in layouts)
    for layout in layouts:
        for name, at in layout.column.items():
            longest[at] = max([longest[at], *map(len, name.split("\n"))])
    widths = [2 * PADDING + LETTER * letters for letters in longest]
    left = [MARGIN + sum(widths[:at]) + COLUMN_GAP * at for at in range(len(widths))]
    arrows, boxes, top = [], [], float(MARGIN)
    for layout in layouts:
        arrows += [_arrow(layout, top, left, widths, step) for step in layout.steps]
        boxes += [_box(layout, top, left[at], widths[at], name) for name, at in sorted(layout.column.items())]
        top += layout.depth + ROW_GAP
    width, height = left[-1] + widths[-1] + MARGIN, top - ROW_GAP + MARGIN
    return "\n".join(
        [
            f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}" width="{width:.0f}"'
            f' font-family="DejaVu Sans, Verdana, sans-serif" font-size="11" fill="{INK}">',
            "<title>The rules, and which needs what</title>",
            '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7"'
            ' orient="auto">'
            f'<path d="M0 0L8 4L0 8z" fill="{QUIET}"/></marker></defs>',
            '<rect width="100%" height="100%" fill="white"/>',
            f'<g fill="none" stroke="{QUIET}">',
            *arrows,
            "</g>",
            f'<g stroke="{INK}" stroke-width="0.8">',
            *(rectangle for rectangle, _ in boxes),
            "</g>",
            '<g text-anchor="middle">',
            *(text for _, text in boxes),
            "</g>",
            "</svg>\n",
        ]
    )


def _arrow(layout: Layout, top: float, left: list[float], widths: list[float], step: tuple[Point, Point]) -> str:
    """A curve from the right of a box, or of a column that it passes, to the left of the next column."""
    (name, at), (after, to) = step
    y0, y1 = (top + layout.middle[point] for point in step)
    x0, x1 = left[at] + widths[at], left[to]
    start = f"M{x0:.0f} {y0:.0f}" if layout.column[name] == at else f"M{left[at]:.0f} {y0:.0f}H{x0:.0f}"
    bend = (x0 + x1) / 2
    head = ' marker-end="url(#head)"' if layout.column[after] == to else ""
    return f'<path d="{start}C{bend:.0f} {y0:.0f} {bend:.0f} {y1:.0f} {x1:.0f} {y1:.0f}"{head}/>'


def _box(layout: Layout, top: float, x: float, width: float, name: str) -> tuple[str, str]:
    """A rectangle, and the lines of its text."""
    lines, point = name.split("\n"), (name, layout.column[name])
    height, middle = layout.height(point), top + layout.middle[point]
    fill = FIGURE if name.startswith("fig") else RULE
    first = middle - (len(lines) - 1) * LINE / 2 + 4  # of the lines: the text stands on it
    spans = (
        f'<tspan x="{x + width / 2:.0f}" y="{first + n * LINE:.0f}">{line}</tspan>' for n, line in enumerate(lines)
    )
    rectangle = f'x="{x:.0f}" y="{middle - height / 2:.0f}" width="{width:.0f}" height="{height:.0f}" rx="3"'
    return f'<rect {rectangle} fill="{fill}"/>', f"<text>{''.join(spans)}</text>"


def setup(app):
    """Draw the graph before the documents are read."""
    app.connect("builder-inited", lambda _: PICTURE.write_text(drawn(ask()), encoding="utf-8"))
    return {"parallel_read_safe": True}

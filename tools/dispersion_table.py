"""Print the table of damping ratios against the amplitude, of docs/theory.md.

`.venv/bin/python tools/dispersion_table.py results/amplitude_dependence.nc`.
"""

import sys

import numpy as np
import xarray as xr

from rockdamp.arrays import Array
from rockdamp.studies.amplitude_dependence import BEST


def table(dataset: xr.Dataset) -> list[str]:
    """Return, as a table in Markdown, each damper's spreads and the closed form's largest differences, in %.

    Spreads are those of the middle e, over all curves; differences are the largest of either sign over curves and
    amplitudes, one for each e.
    """
    e = dataset["restitution"].values
    differences = {
        "closed form less peaks": ("damping_ratio_energy", "damping_ratio_peaks"),
        "middle energy less peaks": ("damping_ratio_middle", "damping_ratio_peaks"),
        "closed form less Err": ("damping_ratio_energy", "damping_ratio"),
        "middle energy less Err": ("damping_ratio_middle", "damping_ratio"),
    }
    head = ["model", *(f"spread, {name}" for name in ("closed form", "peaks", "Err")), *differences]
    lines = ["| " + " | ".join(head) + " |", "|---" * len(head) + "|"]
    for model in map(str, dataset["damping_model"].values):
        of_model = dataset.sel(damping_model=model)
        middle = of_model.isel(restitution=e.size // 2)
        cells = ["best n" if model == BEST else model]
        for source in ("energy", "peaks", "error"):
            percent = 100 * middle[f"spread_{source}"].values
            cells.append(f"{percent.min():.1f} to {percent.max():.1f}")
        for first, second in differences.values():
            difference = 100 * (of_model[first] / of_model[second] - 1)
            cells.append(" / ".join(largest(difference.isel(restitution=i).values) for i in range(e.size)))
        lines.append("| " + " | ".join(cells) + " |")
    return lines


def largest(percent: Array) -> str:
    """Return the value furthest from zero, as text with its sign; a zero has none."""
    text = f"{percent.ravel()[np.abs(percent).argmax()]:+.1f}"
    return "0.0" if float(text) == 0 else text


if __name__ == "__main__":
    with xr.open_dataset(sys.argv[1]) as opened:
        print("\n".join(table(opened)))

"""Texts with computed numbers, compared as values: another processor may turn their last digits.

Compiled code rounds otherwise where vectors are wider. A number on the border between two last digits then falls to
either side.
"""

import re

import numpy as np

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.(\d+))?(?:[eE]([-+]?\d+))?(?!\w)")
FEW = 0.01  # of many numbers may lie on such a border: more would be another result


def parted(text):
    """Return the words, the numbers, and the unit of the last digit of each; with semicolons commas are decimal."""
    text = text.replace(",", ".") if ";" in text else text
    found = list(NUMBER.finditer(text))
    values = np.array([float(number[0]) for number in found])
    units = np.array([10.0 ** (int(number[2] or 0) - len(number[1] or "")) for number in found])
    return NUMBER.sub("#", text).split(), values, units


def alike(one, other):
    """Whether two texts have the same words, and the same numbers to a unit of the coarser last digit."""
    (words, values, units), (other_words, other_values, other_units) = parted(one), parted(other)
    within = 1.01 * np.maximum(units, other_units) if words == other_words else 0.0
    return words == other_words and bool((np.abs(values - other_values) <= within).all())


def holds(text, part):
    """Whether some lines of a text are those of a part of it."""
    lines, count = text.splitlines(), len(part.splitlines())
    return any(
        alike("\n".join(lines[at : at + count]), part) for at in range(len(lines) - count + 1)
    )


def assert_shipped(made, shipped):
    """What a program makes is what is shipped: all numbers to their last digit, and nearly all of them wholly."""
    assert alike(made, shipped)
    assert np.mean(parted(made)[1] != parted(shipped)[1]) < FEW

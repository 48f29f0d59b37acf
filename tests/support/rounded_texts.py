"""Texts with computed numbers, compared as values: another processor may turn their last digits.

Compiled code rounds otherwise where vectors are wider. A number on the border between two last
digits then falls to either side.
"""

import re

import numpy as np

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.(\d+))?(?:[eE]([-+]?\d+))?(?!\w)")
FEW = 0.01  # of many numbers may lie on such a border: more would be another result


def split_numbers(text):
    """Return the words, the numbers, and the unit of the last digit of each.

    Commas are decimal in a text with semicolons.
    """
    if ";" in text:
        text = text.replace(",", ".")
    matches = list(NUMBER.finditer(text))
    values = np.array([float(match[0]) for match in matches])
    exponents = [int(match[2] or 0) - len(match[1] or "") for match in matches]
    return NUMBER.sub("#", text).split(), values, 10.0 ** np.array(exponents)


def alike(text, other_text):
    """Whether texts have the same words, and numbers to a unit of the coarser last digit."""
    words, values, units = split_numbers(text)
    other_words, other_values, other_units = split_numbers(other_text)
    if words != other_words:
        return False
    tolerance = 1.01 * np.maximum(units, other_units)
    return bool((np.abs(values - other_values) <= tolerance).all())


def holds(text, part):
    """Whether some lines of a text are those of a part of it."""
    lines = text.splitlines()
    count = len(part.splitlines())
    starts = range(len(lines) - count + 1)
    return any(alike("\n".join(lines[start : start + count]), part) for start in starts)


def assert_shipped(text, shipped):
    """Assert that a program's text is as shipped, to its last digits, which nearly never differ."""
    assert alike(text, shipped)
    assert np.mean(split_numbers(text)[1] != split_numbers(shipped)[1]) < FEW

"""How accurate the published numbers are: convergence, energy, small rotations, exact minima.

Checks of this package by itself; comparisons with other programs are tests.
"""

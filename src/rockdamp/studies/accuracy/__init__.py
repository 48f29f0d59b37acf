"""Accuracy of the published numbers: convergence, energy, small rotations, exact minima.

Checks of this package by itself; comparisons with other programs are tests.
"""

"""Statistics that know nothing of walls: the fragility fit, resampling, weighted quantiles.

What they are taken of is decided in studies.
"""

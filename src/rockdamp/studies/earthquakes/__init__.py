"""Walls under earthquakes: incremental dynamic analysis, comparison of dampers, a population of walls.

The records are read in motions, fragilities are fitted in statistics.
"""

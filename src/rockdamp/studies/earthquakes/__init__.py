"""Walls under earthquakes: incremental dynamic analysis and comparison of dampers.

The records are read in motions, fragilities are fitted in statistics.
"""

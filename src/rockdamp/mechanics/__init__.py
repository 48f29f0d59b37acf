"""Formulas of the wall, its force-displacement curve, its dampers and the rigid bodies behind it.

The solvers step in time, `storage` handles files, and `studies` reads the config.
"""

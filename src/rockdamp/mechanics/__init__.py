"""The wall, its force-displacement curve, its dampers and the rigid bodies behind it: formulas of one instant.

No time stepping, no files, no config: those are solvers, storage and studies.
"""

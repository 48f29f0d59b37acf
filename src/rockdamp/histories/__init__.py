"""Time histories of a wall as its user sees them: in metres and seconds, with names, half cycles and phases.

No grids and no comparisons over many walls: those are studies.
"""

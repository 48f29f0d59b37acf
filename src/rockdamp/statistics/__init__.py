"""Statistics without walls: the fragility fit, the bootstrap over stations, and paired comparisons.

The studies decide which histories they are taken from.
"""

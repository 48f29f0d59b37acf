"""Ground motions: records and their files, the sets of FEMA P695, and intensity measures.

The response of a wall to them is in histories.
"""

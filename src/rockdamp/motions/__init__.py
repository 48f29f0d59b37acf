"""Ground motions: files of records, the sets of FEMA P695, measures of intensity, and the synthetic test.

What a wall does under them is in histories.
"""

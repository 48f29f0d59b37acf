"""Ground motions: files of records, the sets of FEMA P695, a pulse, measures of intensity.

What a wall does under them is in histories.
"""

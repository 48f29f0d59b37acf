"""Ground motions: files of records, the sets of FEMA P695, pulses, measures of intensity, channels of a laboratory.

What a wall does under them is in histories.
"""

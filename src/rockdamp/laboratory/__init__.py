"""Measured tests: curve and restitution from a record or free rocking, and trials of blocks.

No commands and no files; figures and tables of the results lie above.
"""

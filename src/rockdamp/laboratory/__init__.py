"""Measured tests: curve and restitution from a record or from free rocking, and trials of rocking blocks.

No commands and no files; figures and tables of the results lie above.
"""

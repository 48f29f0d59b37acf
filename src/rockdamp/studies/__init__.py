"""The stages of the pipeline: each turns its section of the config and earlier datasets into one
dataset.

The only science that sees the config. Formulas belong further down, pictures in figures.
"""

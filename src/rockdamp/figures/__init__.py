"""Figures: functions from stored datasets to Matplotlib figures, each in a module named after what it shows.

Nothing here simulates. Which datasets each is given, and what is said of it, stands in pipeline/figures.yaml.
"""

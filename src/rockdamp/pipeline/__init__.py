"""Describe the pipeline once: the table of stages, and the table of figures.

Rules, report and tests follow from these tables. They name functions of the science and import none of it.
"""

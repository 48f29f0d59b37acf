"""Describe the pipeline once: the table of stages, the table of figures, and the data dictionary.

Rules, report and tests follow from these tables. They name functions of the science and import none of it.
"""

"""The report: one page that needs nothing but itself, with every number taken from the datasets."""

from rockdamp.report.page import Content, build, write

__all__ = ["Content", "build", "write"]

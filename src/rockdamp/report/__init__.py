"""The report: one self-contained page, with every number from the datasets."""

from rockdamp.report.page import Content, build, write

__all__ = ["Content", "build", "write"]

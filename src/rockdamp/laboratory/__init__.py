"""Wall and damper from a measured record: the posterior of the parameters and the evidence of the models.

No commands and no files; figures and tables of the results lie above.
"""

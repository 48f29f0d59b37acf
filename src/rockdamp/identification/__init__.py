"""What a measured record says of wall and damper: the posterior of the parameters and the evidence of the models.

No commands and no files: what is drawn and printed of it lies above.
"""

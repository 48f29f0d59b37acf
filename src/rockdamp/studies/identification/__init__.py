"""What a measured record says of wall and damper: the posterior of the parameters, the evidence of the models, and
whether both are right about themselves."""

"""`python -m rockdamp` is the command `rockdamp`."""

from rockdamp.cli import main

main(prog_name="rockdamp")

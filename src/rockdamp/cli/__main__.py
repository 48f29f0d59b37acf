"""`python -m rockdamp.cli` is `rockdamp`."""

from rockdamp.cli import main

main(prog_name="rockdamp")

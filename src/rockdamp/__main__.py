"""Start the command line by `python -m rockdamp`."""

from rockdamp.cli import main

if __name__ == "__main__":
    main(prog_name="rockdamp")

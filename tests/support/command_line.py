"""The command line as a user types it: what it prints, and what it refuses."""

import json

from click.testing import CliRunner

from rockdamp.cli import main


def run(*arguments):
    return CliRunner().invoke(main, [str(argument) for argument in arguments])


def printed(*arguments):
    """Return the JSON that a command prints."""
    result = run(*arguments, "--json")
    assert result.exit_code == 0, result.output
    return json.loads(result.stdout)


def refused(*arguments):
    """Standard error of a command that must end with status 2 and print nothing."""
    result = run(*arguments)
    assert result.exit_code == 2, result.output
    assert isinstance(result.exception, SystemExit) and result.stdout == ""
    assert "Error:" in result.stderr and "Traceback" not in result.stderr
    return result.stderr

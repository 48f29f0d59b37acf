"""All results of a config against what their rules make in this tree: a line for each that is another's."""

import sys
from pathlib import Path

from rockdamp.motions import catalogue
from rockdamp.pipeline import soundness

expected = list(soundness.results(snakemake.config, lambda entries: len(catalogue.listing(entries))))
lines = [f"{file} {reason}" for file, reason in soundness.unsound(snakemake.config["results"], expected)]
Path(snakemake.log[0]).write_text("".join(f"{line}\n" for line in lines), encoding="utf-8")
for line in lines:
    print(f"verify: {line}", file=sys.stderr)
sys.exit(1 if lines else 0)

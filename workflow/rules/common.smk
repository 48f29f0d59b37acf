"""What the rules share: where things are built, and what a job depends on besides its data."""

RESULTS = config["results"]
LOGS = f"logs/{Path(RESULTS).name}"


def code(module):
    """Return the files of the package that `module` depends on; each dataset is written and read by the registry."""
    return [os.path.relpath(path) for path in files_of(module, "rockdamp.dataset")]


def version(module):
    """Return version and digest of the same files."""
    return code_version(module, "rockdamp.dataset")


def part(*keys):
    """Return a function of the wildcards: the part of the config that a job uses, and that makes it run again."""

    def of_job(wildcards):
        return subset(config, *(key.format(**dict(wildcards.items())) for key in keys))

    return of_job


def figure(name):
    """Return the files of a figure, in every format that the config asks for."""
    return [f"{RESULTS}/figures/{name}.{suffix}" for suffix in config["figures"]["formats"]]

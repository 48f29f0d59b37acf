"""What the rules share: where things are built, and what a job depends on besides its data."""

RESULTS = config["results"]
LOGS = f"logs/{Path(RESULTS).name}"


def code(module):
    """Return the files of the package that `module` depends on; each dataset is written and read by the registry."""
    return [os.path.relpath(path) for path in files_of(module, "rockdamp.storage.dataset")]


def version(module):
    """Return version and digest of the same files."""
    return code_version(module, "rockdamp.storage.dataset")


def part(*keys):
    """Return a function of the wildcards: the part of the config that a job uses, and that makes it run again."""

    def of_job(wildcards):
        return subset(config, *(key.format(**dict(wildcards.items())) for key in keys))

    return of_job


CAPTIONS = yaml_file.load(Path(ROOT, "report/captions.yaml").read_text(encoding="utf-8"))


def figure(name):
    """Return the files of a figure, in every format that the config asks for; `snakemake --report` shows the PNG."""
    number, _, shows = CAPTIONS.get(name, {"title": name})["title"].rpartition(": ")
    files = {suffix: f"{RESULTS}/figures/{name}.{suffix}" for suffix in config["figures"]["formats"]}
    if "png" in files:
        files["png"] = report(
            files["png"],
            caption=f"../report/{name}.rst",
            category="Figures of the paper" if number else "Beyond the paper",
            labels={"figure": number or name, "shows": shows},
        )
    return list(files.values())

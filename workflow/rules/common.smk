"""What the rules share: where things are built, and what a job depends on besides its data."""

RESULTS = config["results"]
LOGS = f"logs/{Path(RESULTS).name}"


def code(*modules):
    """Return the files of the package that `modules` depend on; each dataset is written and read by the registry."""
    return [os.path.relpath(path) for path in files_of(*modules, "rockdamp.storage.dataset")]


def version(*modules):
    """Return version and digest of the same files."""
    return code_version(*modules, "rockdamp.storage.dataset")


def part(*keys):
    """Return a function of the wildcards: the part of the config that a job uses, and that makes it run again."""

    def of_job(wildcards):
        return subset(config, *(key.format(**dict(wildcards.items())) for key in keys))

    return of_job


def shares(count, per_job):
    """Return the numbers of the jobs that work on `count` things, `per_job` of them at a time."""
    return range(-(-count // per_job))


BY_RECORDS = shares(len(catalogue.listing(config["records"])), config["natural"]["records_per_job"])
SHARES = {
    "natural/records-{share}": BY_RECORDS,
    "natural/orders-{share}": BY_RECORDS,
    "population/walls-{share}": shares(config["population"]["walls"], config["population"]["walls_per_job"]),
}


def built(datasets, stage=None):
    """Return the files of datasets: of every study and share, but where the stage that they are for has its own."""
    files = []
    for name in datasets:
        every = {"study": list(STUDIES), "share": SHARES.get(name, [])}
        own = stage.file if stage else ""
        free = {key: values for key, values in every.items() if f"{{{key}}}" in name and f"{{{key}}}" not in own}
        files += expand(f"{RESULTS}/{name}.nc", **free, allow_missing=True)
    return files


def stated(key):
    """Return the value of a dotted key of the config."""
    value = config
    for name in key.split("."):
        value = value[name]
    return value


def motions(stage):
    """Return the files of the ground motions that a stage reads by itself."""
    return [os.path.relpath(path) for path in catalogue.files_of(stated(stage.motions))] if stage.motions else []


def said(stage):
    """Return what a rule says while it runs."""
    wildcards = [f"{key} {{wildcards.{key}}}" for key in ("study", "share") if f"{{{key}}}" in stage.file]
    return ": ".join([stage.title, *wildcards])


def drawn(figure):
    """Return the files of a figure, in every format that the config asks for; `snakemake --report` shows the PNG."""
    files = {suffix: f"{RESULTS}/figures/{figure.name}.{suffix}" for suffix in config["figures"]["formats"]}
    files["png"] = report(
        files["png"],
        caption="../report/figure.rst",
        category="Figures of the paper" if figure.number else "Beyond the paper",
        labels={"figure": figure.number or figure.name, "shows": figure.title.removeprefix(f"{figure.number}: ")},
    )
    return list(files.values())

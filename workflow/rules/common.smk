"""What the rules share: where things are built, and what a job depends on besides its data."""

RESULTS = config["results"]
TAG = soundness.tag(RESULTS)
LOGS = f"logs/{TAG}"
STATES = soundness.STATES / TAG
FOLDERS = {RESULTS: "the results", f"{RESULTS}/{notes.FOLDER}": "the notes on the results", LOGS: "the logs"}


def code(*modules):
    """Return the files of the package that `modules` depend on; each dataset is written and read by the registry."""
    return [os.path.relpath(path) for path in files_of(*modules, "rockdamp.storage.dataset")]


def version(*modules):
    """Return version and digest of the same files."""
    return soundness.version(*modules)


def part(*keys):
    """Return a function of the wildcards: the part of the config that a job uses, and that makes it run again."""

    def of_job(wildcards):
        return subset(config, *(key.format(**dict(wildcards.items())) for key in keys))

    return of_job


def stated(key):
    """Return the value of a dotted key of the config."""
    return soundness.stated(config, key)


def state(name):
    """Return the file that is newer than a result not made by its rule in this tree, so that it is built again."""
    return f"{STATES}/{name}.json"


def count(entries):
    """Return how many ground motions a list names."""
    return len(catalogue.listing(entries))


def shares(dataset):
    """Return the numbers of the shares that make up a dataset, whose name has {share} in it."""
    (stage,) = [stage for stage in STAGES.values() if stage.dataset == dataset]
    return soundness.shares(stage, config, count)


def built(datasets, stage=None):
    """Return the files of datasets: of every study and share, but where the stage that they are for has its own."""
    files, own = [], stage.file if stage else ""
    for name in datasets:
        every = {}
        if "{study}" in name and "{study}" not in own:
            every["study"] = list(STUDIES)
        if "{share}" in name and "{share}" not in own:
            every["share"] = shares(name)
        files += expand(f"{RESULTS}/{name}.nc", **every, allow_missing=True)
    return files


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

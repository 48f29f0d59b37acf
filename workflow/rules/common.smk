"""What the rules share: where files lie, and what a job depends on besides its input files."""

RESULTS = CONFIG.results
STAGES = built(CONFIG)
REPORTED = reported(STAGES.values())
FIGURES = drawn(REPORTED)
# The logs of results/minimal are in logs/results/minimal, those of /scratch/my-wall in logs/scratch/my-wall.
inside = not os.path.relpath(RESULTS).startswith("..")
LOGS = os.path.join("logs", os.path.relpath(RESULTS) if inside else os.path.abspath(RESULTS)[1:])


def motion_count(entries):
    """Return how many ground motions a list in the config names."""
    return len(catalogue.listing(entries))


STUDY_OR_CHUNK = re.compile(r"\{(study|chunk)\}")

# By which config and code each dataset and table must be made, by its file in the folder of the results.
ORIGINS = origins(CONFIG, motion_count)
DRAWN = [f"figures/{name}.{suffix}" for name in FIGURES for suffix in CONFIG.figures.formats]
RESULT_FILES = [*ORIGINS, *DRAWN, "report.html", "paper.html"]


def expected_attributes(wildcards, input):
    """Return the attributes that each dataset must state which a job reads; the job refuses another."""
    results = {path: os.path.relpath(path, RESULTS) for path in input}
    return {path: ORIGINS[file]._asdict() for path, file in results.items() if file in ORIGINS and file.endswith(".nc")}


def config_part(keys):
    """Return a function of the wildcards: the values of the config that a job uses, and that make it run again."""

    def part(wildcards):
        return CONFIG.leaves(*(key.format(**dict(wildcards.items())) for key in keys))

    return part


def dataset_files(names, stage=None):
    """Return the files of datasets, of every study and chunk. A stage takes its own study and chunk instead."""
    files, output = [], stage.file if stage else ""
    for name in names:
        every = {}
        if "{study}" in name and "{study}" not in output:
            every["study"] = list(STUDIES)
        if "{chunk}" in name and "{chunk}" not in output:
            (writer,) = [stage for stage in STAGES.values() if stage.dataset == name]
            every["chunk"] = list(writer.chunks(CONFIG, motion_count))
        files += expand(f"{RESULTS}/{name}.nc", **every, allow_missing=True)
    return files


def inputs_of(stage):
    """Return a function of the wildcards: the files of a stage by the names of its function's arguments.

    Beside them stand the ground motions and the trials that it reads by itself.
    """

    def files(wildcards):
        named = {argument: value_at(key, ()) for argument, key in stage.records.items()}
        for argument, dataset in stage.inputs.items():
            paths = expand(dataset_files([dataset], stage), **dict(wildcards.items()))
            of_one = not STUDY_OR_CHUNK.search(dataset) or STUDY_OR_CHUNK.search(stage.file)
            named[argument] = paths[0] if of_one else paths
        itself = {"motions": motion_files(stage), "trials": value_at(stage.trials, ())}
        return {name: value if isinstance(value, str) else list(value) for name, value in (named | itself).items()}

    return files


def value_at(key, otherwise):
    return attrgetter(key)(CONFIG) if key else otherwise


def motion_files(stage):
    """Return the files of the ground motions that a stage reads by itself."""
    return [os.path.relpath(path) for path in catalogue.files_of(value_at(stage.motions, ()))]


def message_of(stage):
    """Return what a rule says while it runs."""
    wildcards = [f"{key} {{wildcards.{key}}}" for key in ("study", "chunk") if f"{{{key}}}" in stage.file]
    return ": ".join([stage.title, *wildcards])


def figure_files(figure):
    """Return the files of a figure, in every format that the config asks for; `snakemake --report` shows the PNG."""
    files = {suffix: f"{RESULTS}/figures/{figure.name}.{suffix}" for suffix in CONFIG.figures.formats}
    files["png"] = report(
        files["png"],
        caption="../report/figure.rst",
        category="Figures of the paper" if figure.number else "Beyond the paper",
        labels={"figure": figure.number or figure.name, "shows": figure.title.removeprefix(f"{figure.number}: ")},
    )
    return list(files.values())


def each_input(stage):
    """Return the names of a stage's inputs, of every study."""
    return [name for dataset in stage.datasets for name in each_study(dataset)]

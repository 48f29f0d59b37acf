"""A population of walls under earthquakes: one job for a share of the walls, then what they say together."""

WALLS, PER_JOB = config["population"]["walls"], config["population"]["walls_per_job"]


rule population_walls:
    input:
        code=code("rockdamp.studies.earthquakes.population"),
    output:
        f"{RESULTS}/population/walls.nc",
    log:
        f"{LOGS}/population/walls.log",
    params:
        function="rockdamp.studies.earthquakes.population.walls",
        kind="population_walls",
        version=version("rockdamp.studies.earthquakes.population"),
        config=part(
            "population.walls",
            "population.seed",
            "population.parameters",
            "population.correlations",
            "release_amplitude",
        ),
    message:
        "The walls of the population"
    script:
        "../scripts/dataset.py"


rule population_share:
    input:
        walls=rules.population_walls.output[0],
        watched=[os.path.relpath(path) for path in catalogue.files_of(config["population"]["records"])],
        code=code("rockdamp.studies.earthquakes.population"),
    output:
        f"{RESULTS}/population/walls-{{share}}.nc",
    log:
        f"{LOGS}/population/walls-{{share}}.log",
    wildcard_constraints:
        share=r"\d+",
    params:
        function="rockdamp.studies.earthquakes.population.share",
        kind="population_share",
        version=version("rockdamp.studies.earthquakes.population"),
        config=part(
            "population.walls_per_job",
            "population.records",
            "population.intensity",
            "population.step",
            "population.tail",
        ),
    message:
        "The population under earthquakes, share {wildcards.share} of the walls"
    script:
        "../scripts/dataset.py"


rule population:
    input:
        walls=rules.population_walls.output[0],
        shares=expand(rules.population_share.output[0], share=range(-(-WALLS // PER_JOB))),
        code=code("rockdamp.studies.earthquakes.population"),
    output:
        f"{RESULTS}/population.nc",
    log:
        f"{LOGS}/population.log",
    params:
        function="rockdamp.studies.earthquakes.population.gather",
        kind="population",
        version=version("rockdamp.studies.earthquakes.population"),
        lazy=True,
        config=part("population.bootstrap"),
    message:
        "Fragility of the population, and what it depends on"
    script:
        "../scripts/dataset.py"

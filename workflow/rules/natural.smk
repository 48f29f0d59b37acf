"""Walls under natural ground motions: one job for a share of the records, then what they say together."""

from rockdamp.motions import catalogue

MOTIONS = len(catalogue.listing(config["records"]))
SHARES = range(-(-MOTIONS // config["natural"]["records_per_job"]))


rule natural_walls:
    input:
        equivalence=rules.equivalence_fit.output[0],
        code=code("rockdamp.studies.earthquakes.incremental"),
    output:
        f"{RESULTS}/natural/walls.nc",
    log:
        f"{LOGS}/natural/walls.log",
    params:
        function="rockdamp.studies.earthquakes.incremental.walls",
        kind="natural_walls",
        version=version("rockdamp.studies.earthquakes.incremental"),
        config=part("natural.walls", "natural.restitution", "release_amplitude", "matching.window"),
    message:
        "Damping ratios of the walls that earthquakes shake"
    script:
        "../scripts/dataset.py"


rule natural_records:
    input:
        walls=rules.natural_walls.output[0],
        watched=[os.path.relpath(path) for path in catalogue.files_of(config["records"])],
        code=code("rockdamp.studies.earthquakes.incremental"),
    output:
        f"{RESULTS}/natural/records-{{share}}.nc",
    log:
        f"{LOGS}/natural/records-{{share}}.log",
    wildcard_constraints:
        share=r"\d+",
    params:
        function="rockdamp.studies.earthquakes.incremental.chunk",
        kind="natural_records",
        version=version("rockdamp.studies.earthquakes.incremental"),
        config=part(
            "records",
            "natural.walls",
            "natural.restitution_change",
            "natural.scale",
            "natural.step",
            "natural.tail",
            "natural.records_per_job",
        ),
    message:
        "Walls under earthquakes, share {wildcards.share} of the records"
    script:
        "../scripts/dataset.py"


rule natural_study:
    input:
        walls=rules.natural_walls.output[0],
        shares=expand(rules.natural_records.output[0], share=SHARES),
        code=code("rockdamp.studies.earthquakes.incremental"),
    output:
        f"{RESULTS}/natural.nc",
    log:
        f"{LOGS}/natural.log",
    params:
        function="rockdamp.studies.earthquakes.incremental.gather",
        kind="natural",
        version=version("rockdamp.studies.earthquakes.incremental"),
        config=part(
            "records",
            "release_amplitude",
            "matching.window",
            "natural.walls",
            "natural.restitution",
            "natural.restitution_change",
            "natural.scale",
            "natural.step",
            "natural.tail",
            "natural.records_per_job",
        ),
    message:
        "Peaks and collapses of every wall under every record"
    script:
        "../scripts/dataset.py"


rule comparison:
    input:
        natural=rules.natural_study.output[0],
        code=code("rockdamp.studies.earthquakes.comparison"),
    output:
        f"{RESULTS}/comparison.nc",
    log:
        f"{LOGS}/comparison.log",
    params:
        function="rockdamp.studies.earthquakes.comparison.compare",
        kind="comparison",
        version=version("rockdamp.studies.earthquakes.comparison"),
        config=part("natural.bands", "natural.bootstrap"),
    message:
        "The dampers against restitution under earthquakes: peaks, collapses and fragilities"
    script:
        "../scripts/dataset.py"


rule natural_check:
    input:
        natural=rules.natural_study.output[0],
        watched=rules.natural_records.input.watched,
        code=code("rockdamp.studies.earthquakes.event_driven_check"),
    output:
        f"{RESULTS}/natural/check.nc",
    log:
        f"{LOGS}/natural/check.log",
    params:
        function="rockdamp.studies.earthquakes.event_driven_check.check",
        kind="natural_check",
        version=version("rockdamp.studies.earthquakes.event_driven_check"),
        config=part("records", "natural.walls", "natural.tail", "natural.check"),
    message:
        "A sample of the histories under earthquakes, solved again event by event"
    script:
        "../scripts/dataset.py"


rule natural:
    input:
        rules.natural_study.output,
        rules.natural_check.output,
        rules.comparison.output,
    message:
        "The study of earthquakes"

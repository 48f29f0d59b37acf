"""Walls under earthquakes, with restitution and every damper, and the assumptions."""

QUAKES = ("records", "earthquakes.walls", "earthquakes.tail")
RUNS = (
    *QUAKES,
    "earthquakes.restitution_change",
    "earthquakes.velocity_ratio",
    "earthquakes.step",
    "earthquakes.chunk",
)


rule earthquake_walls:
    input:
        equivalence="<results>/equivalence.nc",
    output:
        "<results>/earthquakes/walls.nc",
    log:
        "<logs>/earthquakes/walls.log",
    params:
        *stage(
            "studies.earthquakes.walls",
            "solver",
            "earthquakes.walls",
            "earthquakes.restitution",
            "release_amplitude",
            "matching",
            dataset="earthquake_walls",
        ),
    script:
        "../scripts/dataset.py"


rule earthquake_records:
    input:
        RECORD_FILES,
        walls="<results>/earthquakes/walls.nc",
    output:
        "<results>/earthquakes/records-{chunk}.nc",
    log:
        "<logs>/earthquakes/records-{chunk}.log",
    params:
        *stage("studies.earthquakes.chunk", *RUNS, dataset="earthquake_records"),
        *motions(RECORDS),
    script:
        "../scripts/dataset.py"


rule earthquakes_study:
    input:
        walls="<results>/earthquakes/walls.nc",
        chunks=expand("<results>/earthquakes/records-{chunk}.nc", chunk=CHUNKS),
    output:
        "<results>/earthquakes.nc",
    log:
        "<logs>/earthquakes.log",
    params:
        *stage(
            "studies.earthquakes.gather",
            *RUNS,
            "solver",
            "release_amplitude",
            "matching",
            "earthquakes.restitution",
            dataset="earthquakes",
        ),
    script:
        "../scripts/dataset.py"


rule earthquake_check:
    input:
        RECORD_FILES,
        earthquakes="<results>/earthquakes.nc",
    output:
        "<results>/earthquakes/check.nc",
    log:
        "<logs>/earthquakes/check.log",
    params:
        *stage(
            "studies.event_driven_check.check_earthquakes",
            *QUAKES,
            "earthquakes.check",
            dataset="earthquake_check",
        ),
        *motions(RECORDS),
    script:
        "../scripts/dataset.py"


rule comparison:
    input:
        earthquakes="<results>/earthquakes.nc",
    output:
        "<results>/comparison.nc",
    log:
        "<logs>/comparison.log",
    params:
        *stage("studies.comparison.compare_dampers", "comparison", dataset="comparison"),
    script:
        "../scripts/dataset.py"


rule earthquakes:
    input:
        "<results>/earthquakes.nc",
        "<results>/earthquakes/check.nc",
        "<results>/comparison.nc",


rule order_records:
    input:
        RECORD_FILES,
    output:
        "<results>/earthquakes/order-{chunk}.nc",
    log:
        "<logs>/earthquakes/order-{chunk}.log",
    params:
        *stage(
            "studies.order.chunk",
            *QUAKES,
            "earthquakes.velocity_ratio",
            "earthquakes.chunk",
            "order",
            dataset="order_records",
        ),
        *motions(RECORDS),
    script:
        "../scripts/dataset.py"


rule order:
    input:
        chunks=expand("<results>/earthquakes/order-{chunk}.nc", chunk=CHUNKS),
    output:
        "<results>/order.nc",
    log:
        "<logs>/order.log",
    params:
        *stage(
            "studies.order.compare",
            "solver.step",
            "curve",
            "matching.response_length",
            "damping_force.restitution",
            "earthquakes.walls",
            "order",
            "comparison",
            dataset="order",
        ),
    script:
        "../scripts/dataset.py"


rule loss_law:
    input:
        RECORD_FILES,
    output:
        "<results>/loss_law.nc",
    log:
        "<logs>/loss_law.log",
    params:
        *stage(
            "studies.loss_law.loss_law",
            *QUAKES,
            "earthquakes.velocity_ratio",
            "loss_law",
            "comparison",
        ),
        *motions(RECORDS),
    script:
        "../scripts/dataset.py"


rule supports:
    input:
        RECORD_FILES,
    output:
        "<results>/supports.nc",
    log:
        "<logs>/supports.log",
    params:
        *stage("studies.supports.supports", *QUAKES, "supports", "comparison.bootstrap"),
        *motions(RECORDS),
    script:
        "../scripts/dataset.py"

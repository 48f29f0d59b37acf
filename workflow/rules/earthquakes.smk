"""Walls under earthquakes, with restitution and with every damper, and what the answer assumes."""

QUAKES = settings("records", "earthquakes.walls", "earthquakes.tail")
RUNS = settings(
    *(f"earthquakes.{key}" for key in ("restitution_change", "velocity_ratio", "step", "chunk"))
)


rule earthquake_walls:
    input:
        equivalence="<results>/equivalence.nc",
    output:
        "<results>/earthquakes/walls.nc",
    log:
        "<logs>/earthquakes/walls.log",
    params:
        *settings(
            "solver",
            "earthquakes.walls",
            "earthquakes.restitution",
            "release_amplitude",
            "matching",
        ),
        *code("studies.earthquakes"),
        *texts("earthquake_walls"),
        function="studies.earthquakes.walls",
        dataset="earthquake_walls",
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
        *QUAKES,
        *RUNS,
        *code("studies.earthquakes"),
        function="studies.earthquakes.chunk",
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
        *QUAKES,
        *settings("solver", "release_amplitude", "matching", "earthquakes.restitution"),
        *RUNS,
        *code("studies.earthquakes"),
        *texts("earthquakes"),
        function="studies.earthquakes.gather",
        dataset="earthquakes",
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
        *QUAKES,
        *settings("earthquakes.check"),
        *code("studies.event_driven_check"),
        *texts("earthquake_check"),
        function="studies.event_driven_check.check_earthquakes",
        dataset="earthquake_check",
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
        *settings("comparison"),
        *code("studies.comparison"),
        *texts("comparison"),
        function="studies.comparison.compare_dampers",
        dataset="comparison",
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
        *QUAKES,
        *settings("earthquakes.velocity_ratio", "earthquakes.chunk", "order"),
        *code("studies.order"),
        function="studies.order.chunk",
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
        *settings("solver.step", "curve", "matching.response_length", "damping_force.restitution"),
        *settings("earthquakes.walls", "order", "comparison"),
        *code("studies.order"),
        *texts("order"),
        function="studies.order.compare",
        dataset="order",
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
        *QUAKES,
        *settings("earthquakes.velocity_ratio", "loss_law", "comparison"),
        *code("studies.loss_law"),
        *texts("loss_law"),
        function="studies.loss_law.loss_law",
        dataset="loss_law",
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
        *QUAKES,
        *settings("supports", "comparison.bootstrap"),
        *code("studies.supports"),
        *texts("supports"),
        function="studies.supports.supports",
        dataset="supports",
    script:
        "../scripts/dataset.py"

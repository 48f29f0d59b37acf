"""Walls under earthquakes, with restitution and with every damper, and what the answer assumes."""

QUAKES = settings("records", "earthquakes.walls", "earthquakes.tail")


rule earthquake_walls:
    input:
        equivalence=RESULTS + "/equivalence.nc",
    output:
        RESULTS + "/earthquakes/walls.nc",
    log:
        LOGS + "/earthquakes/walls.log",
    params:
        *settings("solver", "earthquakes.walls", "earthquakes.restitution", "release_amplitude", "matching"),
        *code("studies.earthquakes.incremental"),
        *texts("earthquake_walls"),
        function="studies.earthquakes.incremental.walls",
        dataset="earthquake_walls",
    script:
        "../scripts/dataset.py"


rule earthquake_records:
    input:
        RECORD_FILES,
        walls=RESULTS + "/earthquakes/walls.nc",
    output:
        RESULTS + "/earthquakes/records-{chunk}.nc",
    log:
        LOGS + "/earthquakes/records-{chunk}.log",
    params:
        *QUAKES,
        *settings("earthquakes.restitution_change", "earthquakes.velocity_ratio", "earthquakes.step"),
        *settings("earthquakes.chunk"),
        *code("studies.earthquakes.incremental"),
        function="studies.earthquakes.incremental.chunk",
    script:
        "../scripts/dataset.py"


rule earthquakes_study:
    input:
        walls=RESULTS + "/earthquakes/walls.nc",
        chunks=expand(RESULTS + "/earthquakes/records-{chunk}.nc", chunk=CHUNKS),
    output:
        RESULTS + "/earthquakes.nc",
    log:
        LOGS + "/earthquakes.log",
    params:
        *QUAKES,
        *settings("solver", "release_amplitude", "matching", "earthquakes.restitution"),
        *settings("earthquakes.restitution_change", "earthquakes.velocity_ratio", "earthquakes.step"),
        *settings("earthquakes.chunk"),
        *code("studies.earthquakes.incremental"),
        *texts("earthquakes"),
        function="studies.earthquakes.incremental.gather",
        dataset="earthquakes",
    script:
        "../scripts/dataset.py"


rule earthquake_check:
    input:
        RECORD_FILES,
        earthquakes=RESULTS + "/earthquakes.nc",
    output:
        RESULTS + "/earthquakes/check.nc",
    log:
        LOGS + "/earthquakes/check.log",
    params:
        *QUAKES,
        *settings("earthquakes.check"),
        *code("studies.earthquakes.event_driven_check"),
        *texts("earthquake_check"),
        function="studies.earthquakes.event_driven_check.check_earthquakes",
        dataset="earthquake_check",
    script:
        "../scripts/dataset.py"


rule comparison:
    input:
        earthquakes=RESULTS + "/earthquakes.nc",
    output:
        RESULTS + "/comparison.nc",
    log:
        LOGS + "/comparison.log",
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
        RESULTS + "/earthquakes.nc",
        RESULTS + "/earthquakes/check.nc",
        RESULTS + "/comparison.nc",


rule order_records:
    input:
        RECORD_FILES,
    output:
        RESULTS + "/earthquakes/order-{chunk}.nc",
    log:
        LOGS + "/earthquakes/order-{chunk}.log",
    params:
        *QUAKES,
        *settings("earthquakes.velocity_ratio", "earthquakes.chunk", "order"),
        *code("studies.order"),
        function="studies.order.chunk",
    script:
        "../scripts/dataset.py"


rule order:
    input:
        chunks=expand(RESULTS + "/earthquakes/order-{chunk}.nc", chunk=CHUNKS),
    output:
        RESULTS + "/order.nc",
    log:
        LOGS + "/order.log",
    params:
        *settings("solver.step", "curve", "matching.response_length", "damping_force.restitution"),
        *settings("earthquakes.walls", "order", "comparison"),
        *code("studies.order"),
        *texts("order"),
        function="studies.order.compare",
        dataset="order",
    script:
        "../scripts/dataset.py"


rule loss_law_records:
    input:
        RECORD_FILES,
    output:
        RESULTS + "/earthquakes/loss_law.nc",
    log:
        LOGS + "/earthquakes/loss_law.log",
    params:
        *QUAKES,
        *settings("earthquakes.velocity_ratio", "loss_law"),
        *code("studies.loss_law"),
        function="studies.loss_law.histories",
    script:
        "../scripts/dataset.py"


rule loss_law:
    input:
        histories=RESULTS + "/earthquakes/loss_law.nc",
    output:
        RESULTS + "/loss_law.nc",
    log:
        LOGS + "/loss_law.log",
    params:
        *settings("comparison"),
        *code("studies.loss_law"),
        *texts("loss_law"),
        function="studies.loss_law.compare",
        dataset="loss_law",
    script:
        "../scripts/dataset.py"


rule supports_records:
    input:
        RECORD_FILES,
    output:
        RESULTS + "/earthquakes/supports.nc",
    log:
        LOGS + "/earthquakes/supports.log",
    params:
        *QUAKES,
        *settings("supports"),
        *code("studies.supports"),
        function="studies.supports.histories",
    script:
        "../scripts/dataset.py"


rule supports:
    input:
        histories=RESULTS + "/earthquakes/supports.nc",
    output:
        RESULTS + "/supports.nc",
    log:
        LOGS + "/supports.log",
    params:
        *settings("supports", "comparison.bootstrap"),
        *code("studies.supports"),
        *texts("supports"),
        function="studies.supports.compare",
        dataset="supports",
    script:
        "../scripts/dataset.py"

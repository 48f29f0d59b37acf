"""Made-up content for a report: datasets with the glossary's names, tables, and figures of one colour."""

import io
import zlib

import numpy as np
import xarray as xr
from made_up_earthquakes import dimensions
from minimal_build import KINDS
from PIL import Image

from rockdamp.claims import VERDICTS
from rockdamp.constants import MODELS, STUDIES, VISCOUS_MODELS
from rockdamp.figures import FIGURES
from rockdamp.report import Content
from rockdamp.storage import dataset
from rockdamp.studies.amplitude import DAMPERS

COORDINATES = {
    "damping_model": list(MODELS),
    "viscous_model": list(VISCOUS_MODELS),
    "curve_name": ["bi-linear", "tri-linear", "steeper", "translated", "new", "moderate", "severe"],
    "rocking_model": ["tri-linear", "slender", "large rotation"],
    "scheme": ["newmark", "paper"],
    "excitation": ["free", "forced"],
    "parameter": ["a1", "b1", "e"],
    "restitution": [0.8, 0.85, 0.9, 0.95],
    "release_amplitude": [0.3, 0.5, 0.9],
    "slenderness": [10.0, 15.0, 30.0],
    "overburden_ratio": [0.0, 2.0],
    "yield_displacement_ratio": [0.02, 0.04, 0.1],
    "damping_ratio_source": ["polynomial", "least error", "closed form"],
    "variation": ["step", "impact", "lower e", "higher e"],
    "bound": ["lower", "upper"],
    "share": [0.5, 0.9, 1.0],
    "wall": ["veneer", "church", "parapet"],
    "damper": ["ECD", "ECD16", "BAND0.4", "BAND0.2", "CQD0.25", "e - 0.01", "e + 0.01", "half step"],
    "crossing_damper": ["CR", "ECD16", "BAND0.4", "BAND0.2"],
    "tau": [0.05 * i for i in range(61)],
}
SCALARS = {
    "response_length": 8.0,
    "release_amplitude": 0.5,
    "restitution": 0.85,
    "yield_displacement_ratio": 0.04,
    "ultimate_displacement_ratio": 1.0,
    "strength_ratio": 0.85,
    "plateau_end_ratio": 0.15,
}
WITHOUT_CR = {"match", "equivalence", "amplitude", "response_lengths"}


def made_up(kind, parameter=None):
    """A dataset of a kind: coordinates as above, and values between 0 and 1 that depend on kind and name alone."""
    found = {}
    entries, dimensions_of = dataset.variables(kind), dimensions(kind, parameter)
    sizes = {dim: len(coordinate(kind, dim)) for dims in dimensions_of.values() for dim in dims}
    for name, dims in dimensions_of.items():
        dims = tuple(dims)
        if dims == (name,):
            found[name] = (dims, coordinate(kind, name))
        elif not dims and name in SCALARS:
            found[name] = ((), SCALARS[name])
        else:
            random = np.random.default_rng(zlib.crc32(f"{kind} {name}".encode()))
            found[name] = (dims, random.uniform(0.05, 0.95, [sizes[dim] for dim in dims]))
    made = xr.Dataset(found)
    if kind == "match":
        made["strength_ratio"] = (parameter, np.full(sizes[parameter], 0.85))
    for name in dimensions_of:
        made[name].attrs = {key: entries[name][key] for key in dataset.ATTRIBUTES if key in entries[name]}
    attributes = {"title": dataset.glossary()["datasets"][kind]["title"]}
    record = {"record_synthetic": "yes", "record_specimen": "a made-up wall"} if kind == "validation" else {}
    return made.assign_attrs(attributes | record, code_version=f"0.0.0+{kind}")


def of_name(name):
    """A dataset by the name that it has as an input: ``match/amplitude``."""
    return made_up(KINDS[name], STUDIES.get(name.rpartition("/")[2]))


def coordinate(kind, dim):
    if dim == "damping_model" and kind in WITHOUT_CR:
        return list(DAMPERS) if kind == "amplitude" else list(VISCOUS_MODELS)
    if (kind, dim) == ("measured_rocking", "damping_model"):
        return ["CR", "CDC", "CDR", "SDR", "power law"]
    if (kind, dim) == ("order", "wall"):
        return ["paper", *COORDINATES["wall"]]
    if kind in ("supports", "loss_law") and dim == "wall":
        return ["all", *COORDINATES["wall"]]
    return COORDINATES.get(dim, [0, 1, 2])


def png(width, height):
    file = io.BytesIO()
    Image.new("RGB", (width, height), "#FFFFFF").save(file, "PNG")
    return file.getvalue()


def content():
    claims = [
        {
            "id": f"claim-{i}",
            "section": f"{i}.1",
            "claim": f"Claim {i}: a < b & c.",
            "verdict": VERDICTS[i % len(VERDICTS)],
            "measured": f"one of {i} 0.{i}1",
            "threshold": f"less than 0.{i}",
            "finding": f"It is 0.{i}3 u_ins.",
        }
        for i in range(5)
    ]
    errata = [
        {
            "id": f"erratum-{i}",
            "where": f"Eq. ({i})",
            "printed": f"printed {i}",
            "used": f"used {i}",
            "evidence": f"evidence {i} </script>",
        }
        for i in range(3)
    ]
    return Content(
        claims=claims,
        errata=errata,
        figures={name: png(300 if index % 2 else 150, 100 + index) for index, name in enumerate(FIGURES)},
        datasets={name: of_name(name) for name in KINDS},
        yield_displacement_ratio=0.04,
    )

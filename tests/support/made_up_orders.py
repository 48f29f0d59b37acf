"""Made-up histories with ECD of each order and CR with a changed e, whose ratios are known numbers."""

import numpy as np
import xarray as xr
from configs import configured

from rockdamp.studies.earthquakes import orders

SPLITS = {"count": 3, "seed": 5}


def made_up(log_ratio, collapsed=False):
    """A share of 40 records on one wall: CR's peaks at 0.1, changed by factors exp(-+0.1), an order by `log_ratio`."""
    dims = ("record", "velocity_ratio", "wall", "restitution")
    shape = (40, 3, 1, 1)
    peak = np.full(shape, 0.1)
    ratio = np.broadcast_to(log_ratio, (*shape, np.shape(log_ratio)[-1]))
    varied = peak[..., None] * np.exp([0.0, *[-0.1, 0.1] * 3])
    fell = np.zeros(shape, dtype=np.int8)
    fell[:, 2] = 1
    order_fell = np.repeat(fell[..., None], ratio.shape[-1], axis=-1)
    if collapsed:
        order_fell[:4, 2], order_fell[:2, 1] = 0, 1
    return xr.Dataset(
        {
            "reference_peak": (dims, peak),
            "reference_collapsed": (dims, fell),
            "varied_peak": ((*dims, "variation"), varied),
            "varied_collapsed": ((*dims, "variation"), np.repeat(fell[..., None], varied.shape[-1], axis=-1)),
            "peak": ((*dims, "order"), peak[..., None] * np.exp(ratio)),
            "collapsed": ((*dims, "order"), order_fell),
        },
        coords={
            "record": [f"r{i}" for i in range(40)],
            "record_set": ("record", ["own"] * 40),
            "station": ("record", [f"s{i // 2}" for i in range(40)]),
            "velocity_ratio": [0.5, 1.0, 2.0],
            "wall": ["one"],
            "restitution": [0.85],
            "variation": list(orders.VARIATIONS),
            "order": np.arange(ratio.shape[-1], dtype=float),
        },
    )


def compare(given, bands=(0.01, 1.0)):
    statistics = {"bands": list(bands), "bootstrap": {"replicates": 50, "seed": 3}, "splits": SPLITS}
    config = configured({"comparison": statistics})
    return orders.compare_orders(config, [given]).sel(record_set="own", restitution=0.85, change="loss")

"""Write the CSV of a logger as a record that `rockdamp calibrate` reads.

The channels are scaled and filtered, and the wall's displacement becomes relative to the table. Run
it as `python examples/raw_channels.py LOGGER.csv RECORD.csv`, with your columns,
units and signs below.
"""

import sys

import pandas as pd
from scipy.signal import butter, sosfiltfilt

import rockdamp as rd

# Factors that bring the columns to s, m s-2, m and m.
SCALES = {"t": 1.0, "a": 9.80665, "wall": 1e-3, "table": 1e-3}
REST = 0.5  # time before the motion, where all channels are zero [s]
CORNER = 40.0  # frequency of the low pass, which runs both ways and so delays nothing [Hz]
HEADER = {"specimen": "my wall", "source": "my laboratory", "synthetic": "no"}

logger, record = sys.argv[1:]
channels = pd.read_csv(logger, comment="#")[list(SCALES)] * pd.Series(SCALES)
elapsed = channels.pop("t").to_numpy()
channels -= channels[elapsed < elapsed[0] + REST].mean()
rate = (len(elapsed) - 1) / (elapsed[-1] - elapsed[0])
low_pass = butter(4, CORNER, fs=rate, output="sos")
acceleration, wall, table = sosfiltfilt(low_pass, channels, axis=0).T
rd.write_record(record, rd.Record(elapsed, acceleration, wall - table, header=HEADER))

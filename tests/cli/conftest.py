"""A record for the commands that need one."""

import numpy as np
import pytest


@pytest.fixture
def record(tmp_path):
    """A second of a pulse, sampled at 100 Hz."""
    elapsed = 0.01 * np.arange(100)
    motion = np.where(elapsed < 0.4, 3 * np.sin(2 * np.pi * elapsed / 0.4), 0.0)
    path = tmp_path / "pulse.csv"
    rows = "\n".join(f"{t:.2f},{a:.6f}" for t, a in zip(elapsed, motion, strict=True))
    path.write_text(f"# specimen: none\n# synthetic: yes\nelapsed_s,ground_acceleration_m_s2\n{rows}\n")
    return path

"""Where the project lies: tests read its config, data and documents."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

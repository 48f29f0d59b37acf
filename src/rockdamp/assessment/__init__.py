"""From walls and records to an answer: how likely one wall, or each of thousands, collapses."""

"""From a wall and records to an answer: how likely it collapses at an intensity, for one wall or for thousands."""

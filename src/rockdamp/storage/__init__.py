"""Read and write files: CF datasets with their registry variables.yaml, provenance, YAML, whole or not at all."""

"""Read and write files: CF datasets by the glossary, provenance, YAML, whole or not at all."""

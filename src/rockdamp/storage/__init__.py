"""Files: CF datasets with their registry variables.yaml, provenance, YAML, and writes that are whole or not at all.

What the numbers mean is computed elsewhere.
"""

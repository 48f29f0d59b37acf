"""Read and write files: datasets by the glossary, texts, whole or not at all."""

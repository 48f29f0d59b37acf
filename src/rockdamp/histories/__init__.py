"""Time histories of walls in metres and seconds: loads, responses, half cycles and refinement."""

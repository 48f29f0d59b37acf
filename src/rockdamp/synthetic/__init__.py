"""Records that are computed in place of measured ones: a wall's exact response, and the noise of instruments."""

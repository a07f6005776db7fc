"""Sea models: emissivity and BRDF of a wind-roughened surface, and its waves."""

"""A cube recomputed from its own provenance and compared."""

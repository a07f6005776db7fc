"""The scenario file: models, catalog look-up of names, units, errors, reference."""

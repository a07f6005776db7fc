"""Export of cubes to the formats of other programs, one module per format."""

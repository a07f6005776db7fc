"""Where a sensor stands and how it sees each pixel."""

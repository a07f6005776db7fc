"""Static cloud scenes taken from satellite images."""

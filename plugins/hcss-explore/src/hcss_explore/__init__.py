"""A page on this machine to explore a scene."""

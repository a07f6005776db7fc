"""Pictures made from cubes."""

"""Fractal clouds: the multiscale sum of eqs 2-4, for any tile of any frame of an unbounded sky."""

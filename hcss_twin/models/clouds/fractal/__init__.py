"""The multiscale sum of eqs 2-4: any tile of any frame of an unbounded sky."""

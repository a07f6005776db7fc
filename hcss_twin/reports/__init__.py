"""Reports and pictures of cubes, sweeps, posteriors and propagations."""

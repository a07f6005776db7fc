"""Reports and pictures of cubes, sweeps and posteriors."""

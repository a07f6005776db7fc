"""Posteriors of ``hcss fit`` (plugin hcss-evaluate): their file, the mixing of their draws, priors."""

"""Run time against error on the user's machine: each stage, the whole run, and peers, as ratios of one run."""

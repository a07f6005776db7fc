"""Many scenes from one file: the points of a sweep, computed here or on a cluster, resumable."""

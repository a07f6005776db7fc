"""Many scenes from one file: the points of a sweep, computed locally or on a cluster, with resume."""

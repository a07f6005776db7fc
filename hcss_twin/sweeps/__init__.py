"""Sweeps: many scenes from one file, computed locally or on a cluster, with resume."""

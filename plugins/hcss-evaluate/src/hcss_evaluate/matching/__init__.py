"""Estimate cloud parameters from a measured image: Algorithm 1 of the HCSS paper."""

BUDGET = 360
"""Default number of images that the search simulates."""

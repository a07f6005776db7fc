"""Estimate cloud parameters from a measured image: Algorithm 1 of the HCSS paper."""

"""Readers that turn the output of other radiative-transfer codes into our atmosphere table."""

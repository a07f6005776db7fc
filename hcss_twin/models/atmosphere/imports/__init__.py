"""Readers that convert the output of other radiative-transfer codes to our atmosphere table."""

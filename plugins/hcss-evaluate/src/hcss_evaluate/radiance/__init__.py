"""Comparison of simulated with measured brightness temperature of clear sea and opaque clouds."""

from hcss_evaluate.radiance.blind import BlindTest, ChannelDifference, blind_test

__all__ = ["BlindTest", "ChannelDifference", "blind_test"]

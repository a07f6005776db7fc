"""Clouds from satellite images: the image scene itself, or its single clouds scattered over an unbounded sky."""

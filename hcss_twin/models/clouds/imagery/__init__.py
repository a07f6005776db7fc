"""Clouds from satellite images: the scene of an image, or its single clouds scattered over an endless sky."""

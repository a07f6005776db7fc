"""Clouds cut from satellite images and kept: segmentation, the entry and its file, the folder of entries."""

"""Measures images, compares them and estimates cloud parameters from them."""

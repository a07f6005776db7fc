"""Optical properties of cloud particles."""

"""Slant paths: parallax of clouds and their shadows on the sea."""

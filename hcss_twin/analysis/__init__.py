"""Judges images and estimates cloud parameters from them: measures, comparison, matching, uncertainty."""

"""Sea surface models."""

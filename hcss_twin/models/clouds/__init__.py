"""Cloud generators."""

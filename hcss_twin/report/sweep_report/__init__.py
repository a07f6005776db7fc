"""Page of a sweep: its axes, what its points gave, those that failed."""

"""A moist large-eddy model: clouds computed from air, sea and forcings. Nothing outside this package imports it."""

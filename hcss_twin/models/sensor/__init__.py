"""What a sensor makes of the radiance that reaches it: the default model and its stages, one file each."""

"""What a sensor makes of a scene's frames: the second cube of a pair."""

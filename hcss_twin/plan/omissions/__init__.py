"""What a scene does without, and a bound on what that costs."""

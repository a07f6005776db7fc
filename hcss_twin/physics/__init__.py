"""Pure functions of physics; imports nothing of ours."""

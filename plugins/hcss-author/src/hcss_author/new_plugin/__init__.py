"""New packages with a provider: the text of their files, and how they are written."""

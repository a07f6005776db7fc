"""What every package stands on: errors, catalogs, cache, files. Imports nothing of ours."""

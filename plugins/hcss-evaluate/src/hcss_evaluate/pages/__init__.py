"""Report pages and figures of matches, entries, posteriors and evaluations."""

"""Base of all other packages: errors, catalogs, cache, files. Imports none of them."""

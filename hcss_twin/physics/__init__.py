"""Pure physics functions; this package imports no other package of hcss_twin."""

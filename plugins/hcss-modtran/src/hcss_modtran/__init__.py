"""Readers that convert the output of MODTRAN and libRadtran to atmosphere tables of hcss_twin."""

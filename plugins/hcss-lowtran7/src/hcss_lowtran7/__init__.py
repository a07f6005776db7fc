"""Transmittance provider for hcss_twin with the original LOWTRAN7 Fortran."""

"""LOWTRAN7, the original Fortran, as transmittance provider for hcss_twin."""

"""A grey, well-mixed gas as transmittance provider for hcss_twin."""

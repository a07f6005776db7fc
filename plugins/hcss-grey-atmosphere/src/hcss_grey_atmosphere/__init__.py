"""Transmittance provider for hcss_twin: a grey, well-mixed gas."""

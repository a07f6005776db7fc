"""Radiance models: emission, reflection and transmission of sea, clouds and air (HCSS paper, eqs 8 to 20)."""

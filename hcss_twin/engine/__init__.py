"""Computes what a plan decided: radiance tables, frames, certificate, verification."""

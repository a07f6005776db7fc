"""Executes a plan: radiance tables, frames, certificate, verification."""

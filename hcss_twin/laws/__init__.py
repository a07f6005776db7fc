"""Laws of providers as plain functions: the conformance kit and the probes of a run share them.

A law returns nothing if the provider keeps it, and raises :class:`~hcss_twin.laws.law.LawBroken` with the
numbers if not. No module here imports pytest.
"""

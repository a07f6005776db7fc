"""One table of the equations that are computed: what each says, where it is from, and which function computes it.

It is data for docs/equations.md and the tests that keep it true; nothing that computes imports it.
"""

"""Cloud generators: ``fractal`` (eqs 2-5 and 7 of the HCSS paper) and ``imagery``.

A generator returns cloud thickness in m for any window and time. A cloud type (altitudes, microphysics and fractal
parameters) is one TOML file in the catalog, so that new types need no code.
"""

"""Commands: ``hcss import``, ``clouds``, ``match``, ``fit`` and ``evaluate``."""

"""The tables and figures of the HCSS paper, computed again: plugin of hcss_twin with the command ``hcss reproduce``."""

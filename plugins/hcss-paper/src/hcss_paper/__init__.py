"""Plugin of hcss_twin that recomputes the tables and figures of the HCSS paper: ``hcss reproduce``."""

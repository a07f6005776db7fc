"""Plugin of hcss_twin that measures run time against error: ``hcss bench``."""

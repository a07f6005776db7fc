"""The former name of ``python -m hcss_twin``."""

from hcss_twin.__main__ import main

main()

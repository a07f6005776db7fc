"""The former name of ``python -m hcss_twin``."""

from hcss_twin.cli.main import main

main()

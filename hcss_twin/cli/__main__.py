"""``python -m hcss_twin.cli``, for systems where the command is not on the path."""

from hcss_twin.cli.main import main

main()

"""The ``hcss`` command as ``python -m hcss_twin``, for systems where ``hcss`` is not on the path."""

import signal


def main() -> None:
    """Run the command; Ctrl-C while its modules are loaded ends it without a traceback."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from hcss_twin.cli.main import main as run

    run()


if __name__ == "__main__":
    main()

"""The ``hcss`` command, also as ``python -m hcss_twin``, for systems where it is not on the path."""

import signal


def main() -> None:
    """Run the command; while its modules are loaded, Ctrl-C ends it without the traceback of an import."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    from hcss_twin.cli.main import main as run

    run()


if __name__ == "__main__":
    main()

"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the commands ``atmosphere import`` and ``atmosphere plot``."""
    importing = "Combine output of MODTRAN or libRadtran into one table."
    drawing = "Draw one or two providers or tables; two are compared."
    return [
        CommandSpec("atmosphere import", "hcss_modtran.import_command:atmosphere_import", importing),
        CommandSpec("atmosphere plot", "hcss_modtran.plot_command:atmosphere_plot", drawing),
    ]

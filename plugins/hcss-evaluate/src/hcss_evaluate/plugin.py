"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.core.commands import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the commands ``evaluate`` and ``fit``."""
    return [
        CommandSpec("evaluate", "hcss_evaluate.command:evaluate_command", "Compare simulated with real images."),
        CommandSpec("fit", "hcss_evaluate.posterior.command:fit_command", "Sample the posterior of cloud parameters."),
    ]

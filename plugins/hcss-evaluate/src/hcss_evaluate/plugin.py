"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the commands for clouds in images: import, clouds, match, fit and evaluate."""
    return [
        CommandSpec("import", "hcss_evaluate.commands.clouds:import_command", "Extract the clouds of an image."),
        CommandSpec("clouds", "hcss_evaluate.commands.clouds:clouds", "Show the cloud database."),
        CommandSpec("match", "hcss_evaluate.commands.match:match_command", "Estimate cloud parameters of an image."),
        CommandSpec("fit", "hcss_evaluate.commands.fit:fit_command", "Sample the posterior of cloud parameters."),
        CommandSpec(
            "evaluate", "hcss_evaluate.commands.evaluate:evaluate_command", "Compare simulated with real images."
        ),
    ]

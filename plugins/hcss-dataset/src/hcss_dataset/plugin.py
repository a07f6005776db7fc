"""Hook that registers the commands. ``hcss --help`` imports this module, so it must import quickly."""

from __future__ import annotations

from hcss_twin.providers import CommandSpec, hookimpl


@hookimpl
def hcss_commands() -> list[CommandSpec]:
    """Return the commands ``dataset`` and ``score``."""
    return [
        CommandSpec("dataset", "hcss_dataset.command:dataset_command", "Make a labelled set of frames with targets."),
        CommandSpec("score", "hcss_dataset.score_command:score_command", "Score detections in a data set."),
    ]

"""What is refused: fields and messages of errors on purpose."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from hcss_twin.core.errors import HcssError, ScenarioError


def problems_of(work: Callable[[], Any]) -> dict[str, str]:
    """Return the messages of the error that a scenario gives, by field."""
    with pytest.raises(ScenarioError) as caught:
        work()
    return {problem.field: problem.message for problem in caught.value.problems}


def result_or_refusal(work: Callable[[], Any]) -> tuple[Any, HcssError | None]:
    """Return the result of ``work``, or None and its error on purpose; any other error passes."""
    try:
        return work(), None
    except HcssError as error:
        return None, error

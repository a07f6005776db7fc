"""How many examples a test draws: few and always the same by default, many others with --hypothesis-profile=search."""

from hypothesis import settings

HYPOTHESIS_DEFAULT = 100


def examples(count):
    """Settings that draw ``count`` examples, or as many times as many as the profile has more than hypothesis."""
    return settings(max_examples=count * settings.default.max_examples // HYPOTHESIS_DEFAULT, deadline=None)

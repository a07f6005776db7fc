"""A sample of hostile messages and letters: each is answered with an error that names its field, and frames stay."""

import itertools

import pytest

pytest.importorskip("zmq", reason="pyzmq is missing")
pytest.importorskip("hcss_payload", reason="hcss-payload is missing")


def test_a_sample_neither_crashes_the_server_nor_goes_unanswered(tmp_path):
    from hostile import hostile_messages
    from letter_checks import letter_failures, message_failures, served

    with served(tmp_path) as running:
        sample = itertools.islice(hostile_messages(running.values), 0, None, 9)
        found = [*message_failures(running, sample), *letter_failures(running, 10)]
    assert len(found) > 80
    assert [failure for failure in found if failure[1]] == []

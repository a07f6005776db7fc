"""Ordinal numbers in messages."""

import pytest

from hcss_twin.reports.tables import Table


@pytest.mark.parametrize(
    "text", ["1st", "2nd", "3rd", "4th", "10th", "11th", "12th", "13th", "21st", "22nd", "103rd", "111th", "112th"]
)
def test_an_ordinal_has_the_ending_of_its_last_digit_but_for_the_teens(text):
    assert Table.ordinal(int(text[:-2])) == text

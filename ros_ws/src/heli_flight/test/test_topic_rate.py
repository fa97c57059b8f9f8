"""Rates and sizes of messages over a window, by hand."""

import pytest

from heli_flight.topic_rate import BandwidthWindow, RateWindow


def test_three_messages_give_two_intervals():
    window = RateWindow(10)
    assert window.text() == ""
    for time in (5.0, 5.1, 5.4):
        window.add(time)
    # intervals 0.1 and 0.3: mean 0.2, deviation 0.1
    assert window.text() == "average rate: 5.000\n\tmin: 0.100s max: 0.300s std dev: 0.10000s window: 2"


def test_old_intervals_leave_the_window():
    window = RateWindow(2)
    for time in (0.0, 7.0, 7.5, 8.0):
        window.add(time)
    assert window.text() == "average rate: 2.000\n\tmin: 0.500s max: 0.500s std dev: 0.00000s window: 2"


def test_messages_of_one_instant_have_no_rate():
    window = RateWindow(2)
    window.add(1.0)
    window.add(1.0)
    assert window.text().startswith("average rate: 0.000\n")


@pytest.mark.parametrize(
    ("sizes", "expected"),
    [
        ((100, 300), "200 B/s from 2 messages\n\tMessage size mean: 200 B min: 100 B max: 300 B"),
        ((1000, 3000), "2.00 KB/s from 2 messages\n\tMessage size mean: 2.00 KB min: 1.00 KB max: 3.00 KB"),
        (
            (2_000_000, 4_000_000),
            "3.00 MB/s from 2 messages\n\tMessage size mean: 3.00 MB min: 2.00 MB max: 4.00 MB",
        ),
    ],
)
def test_bandwidth_is_bytes_since_the_first_message(sizes, expected):
    window = BandwidthWindow(2)
    window.add(0.0, 9)  # leaves the window
    assert window.text(1.0) == ""
    window.add(1.0, sizes[0])
    window.add(2.0, sizes[1])
    assert window.text(3.0) == expected

"""The recorder's bookkeeping under every order of arrival that topics in bursts can have."""

from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from heli_common.flight_state import FlightState
from heli_common.topics import DATA_TOPICS, TOPICS
from heli_flight.recorder import ACKNOWLEDGE_NS, FlightRecorder

END_NS = 500_000_000
BEYOND_NS = END_NS + 5_000_000


class Bag:
    """Keeps what would be written; between two batches it may be flushed."""

    def __init__(self):
        self.batches, self.remarks = [], None

    def write_all(self, messages):
        for topic, (stamps, data) in messages.items():
            assert stamps == [TOPICS[topic].layout.stamp(each) for each in data]
            assert stamps
        self.batches.append([(topic, stamp) for topic, (stamps, _) in messages.items() for stamp in stamps])

    @property
    def written(self):
        return [message for batch in self.batches for message in batch]

    def close(self, remarks):
        self.remarks = remarks


def messages(topic, last_ns):
    """Serialized messages of a topic up to a stamp; the flight ends at END_NS if that is reached."""
    layout = TOPICS[topic].layout
    for stamp_ns in range(0, last_ns + 1, TOPICS[topic].period_ns):
        values = [0.0] * len(layout.fields)
        if topic == "flight_state":
            values[0] = float(FlightState.STOPPED if stamp_ns >= END_NS else FlightState.FLYING)
        yield layout.pack(stamp_ns, values)


@settings(deadline=None, max_examples=30)
@given(st.permutations(DATA_TOPICS))
def test_bursts_of_topics_in_any_order_are_acknowledged(order):
    # the bench stands still at 490 ms and waits for an acknowledgement: nothing may come after this
    recorder = FlightRecorder(Bag())
    sent = []
    for topic in order:
        for data in messages(topic, END_NS - 10_000_000):
            recorder.receive(topic, data)
        sent.append(recorder.settle())
    acknowledged = [stamp for stamp in sent if stamp is not None]
    assert acknowledged
    assert END_NS - acknowledged[-1] <= ACKNOWLEDGE_NS + 10_000_000
    assert not recorder.complete


@settings(deadline=None, max_examples=30)
@given(st.permutations(DATA_TOPICS))
def test_the_bag_ends_where_the_flight_ended_whatever_the_order(order):
    bag = Bag()
    recorder = FlightRecorder(bag)
    acknowledged = -1
    for topic in order:
        for data in messages(topic, BEYOND_NS if topic == "encoders" else END_NS):
            recorder.receive(topic, data)
        acknowledged = recorder.settle() or acknowledged
    assert recorder.complete
    assert recorder.ended_at == END_NS
    assert acknowledged >= END_NS
    recorder.close({"late": "0"})
    assert bag.remarks == {"late": "0"}
    expected = {
        (topic, stamp) for topic in DATA_TOPICS for stamp in range(0, END_NS + 1, TOPICS[topic].period_ns)
    }
    assert set(bag.written) == expected
    assert len(bag.written) == len(expected)


@settings(deadline=None, max_examples=30)
@given(st.permutations(DATA_TOPICS))
def test_topics_that_come_in_bursts_are_written_together(order):
    # the bag may be flushed after each batch: one written before an older one would be in it alone
    bag = Bag()
    recorder = FlightRecorder(bag)
    for first in (0, 100_000_000):
        for topic in order:
            for data in messages(topic, first + 90_000_000):
                if TOPICS[topic].layout.stamp(data) >= first:
                    recorder.receive(topic, data)
        recorder.settle()
    spans = [(min(stamps), max(stamps)) for batch in bag.batches if (stamps := [stamp for _, stamp in batch])]
    assert all(before[1] < after[0] for before, after in pairwise(spans))
    assert spans[-1][1] == 190_000_000
    for topic in DATA_TOPICS:
        stamps = [stamp for name, stamp in bag.written if name == topic]
        assert stamps == sorted(stamps)


def test_an_interrupted_flight_keeps_everything_that_arrived():
    bag = Bag()
    recorder = FlightRecorder(bag)
    for data in messages("encoders", 50_000_000):
        recorder.receive("encoders", data)
    assert recorder.settle() is None
    assert bag.written == []
    recorder.close({})
    assert len(bag.written) == 21


def test_a_message_of_another_shape_is_refused():
    recorder = FlightRecorder(Bag())
    recorder.receive("encoders", b"1234")
    with pytest.raises(ValueError, match="bytes instead of"):
        recorder.settle()

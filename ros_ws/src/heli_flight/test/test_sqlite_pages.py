"""A database's pages give the same messages as sqlite's rows; where they are unusual, sqlite is asked."""

from __future__ import annotations

import contextlib
import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, example, given, settings
from hypothesis import strategies as st

from heli_common.errors import InputError
from heli_flight import sqlite_reading
from heli_flight.sqlite_pages import UnusualPagesError, find_messages, map_file
from heli_flight.sqlite_reading import read_sqlite
from heli_flight.storage_content import topic_name

TOPICS = "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL)"
COLUMNS = "topic_id INTEGER NOT NULL, timestamp INTEGER NOT NULL, data BLOB NOT NULL"
MESSAGES = f"CREATE TABLE messages(id INTEGER PRIMARY KEY, {COLUMNS})"
NUMBERS = (0, 1, 2, 127, 128, 40_000)
"""Of topics."""
BRANCH, LEAF = 5, 13
"""Kinds of pages, their first byte."""
STAMPS = (0, 1, -1, 2, 127, -128, 128, 2**15, -(2**23), 2**31 - 1, 2**40, -(2**47), 2**47, 2**60, -(2**63))

Row = tuple[int, int, int, object]


def rows_of(count: int, largest: int = 60) -> list[Row]:
    """Rows with every kind of number and message sizes [bytes] up to the largest, with gaps in the ids."""
    rng = np.random.default_rng(1)
    return [
        (k + k // 100, NUMBERS[k % 6], STAMPS[k % len(STAMPS)], rng.bytes(k % (largest + 1)))
        for k in range(1, count + 1)
    ]


def make(
    path: Path, rows: list[Row], page: int = 512, messages: str = MESSAGES, topics: str = TOPICS
) -> Path:
    """A database of topics and messages with pages of this size [bytes]."""
    with closing(sqlite3.connect(path)) as database:
        database.executescript(f"PRAGMA page_size = {page}; {topics}; {messages}")
        database.executemany("INSERT INTO topics VALUES (?, ?, 'a/msg/B')", [(n, f"/t_{n}") for n in NUMBERS])
        database.executemany("INSERT INTO messages (id, topic_id, timestamp, data) VALUES (?, ?, ?, ?)", rows)
        database.commit()
    return path


def by_pages(path: Path) -> list[tuple[int, int, bytes]]:
    """Topic, stamp and message by the pages alone."""
    with closing(sqlite3.connect(path)) as database:
        (root,) = database.execute("SELECT rootpage FROM sqlite_master WHERE name = 'messages'").fetchone()
        (pages,) = database.execute("PRAGMA page_count").fetchone()
    data = map_file(path)
    found = find_messages(data, root, pages)
    numbers = zip(*(array.tolist() for array in vars(found).values()), strict=True)
    return [(topic, stamp, bytes(data[start : start + size])) for topic, stamp, start, size in numbers]


def found_in(path: Path) -> dict[str, tuple[list[int], list[bytes]]]:
    """Stamps and messages by topic."""
    content = read_sqlite(path)
    series = {topic: blocks.joined() for topic, blocks in content.blocks.items()}
    return {topic: (stamps, list(messages)) for topic, (stamps, messages) in series.items()}


@pytest.fixture
def no_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fail where sqlite is asked for the rows."""

    def fail(*_: object) -> None:
        raise AssertionError("the pages were not enough")

    monkeypatch.setattr(sqlite_reading, "_take_rows", fail)


@pytest.mark.parametrize("page", [512, 1024, 4096, 65536])
@pytest.mark.parametrize("count", [0, 1, 5000])
def test_pages_give_the_rows(tmp_path: Path, page: int, count: int) -> None:
    rows = rows_of(count)
    assert by_pages(make(tmp_path / "a.db3", rows, page)) == [row[1:] for row in rows]


@pytest.mark.usefixtures("no_rows")
def test_topics_of_one_and_of_many_sizes_are_sorted_out_by_the_pages(tmp_path: Path) -> None:
    rows: list[Row] = [(k, k % 3, 10 * k, bytes([k % 251]) * (8 if k % 3 else k % 70)) for k in range(40_000)]
    found = found_in(make(tmp_path / "a.db3", rows))
    for topic in range(3):
        of_topic = [row for row in rows if row[1] == topic]
        assert found[f"t_{topic}"] == ([row[2] for row in of_topic], [row[3] for row in of_topic])
    assert found["t_127"] == ([], [])


def test_a_message_that_is_continued_on_another_page_is_left_to_sqlite(tmp_path: Path) -> None:
    # a page of 512 bytes holds a record of 477: 6 of types, 1 for topic 2, none for stamp 0, 470 of data
    for size in (460, 470, 471, 480, 2000):
        rows: list[Row] = [(1, 2, 0, b"a" * size)]
        path = make(tmp_path / f"{size}.db3", rows)
        if size <= 470:
            assert by_pages(path) == [row[1:] for row in rows]
        else:
            with pytest.raises(UnusualPagesError):
                by_pages(path)
        assert found_in(path)["t_2"] == ([0], [b"a" * size])


def test_a_continued_message_in_a_full_page_is_left_to_sqlite(tmp_path: Path) -> None:
    # whatever the first message leaves of the page: the second one's beginning lies in it, its rest does not
    for size in range(400, 430):
        rows: list[Row] = [(1, 2, 0, b"a" * size), (2, 2, 0, b"b" * 471)]
        path = make(tmp_path / f"{size}.db3", rows)
        with pytest.raises(UnusualPagesError):
            by_pages(path)
        assert found_in(path)["t_2"] == ([0, 0], [b"a" * size, b"b" * 471])


@pytest.mark.parametrize(
    "messages",
    [
        f"CREATE TABLE messages(id INTEGER PRIMARY KEY, {COLUMNS}, more TEXT)",
        f"CREATE TABLE messages({COLUMNS}, id INTEGER PRIMARY KEY)",
        f"CREATE TABLE messages(id INTEGER NOT NULL, {COLUMNS})",
        f"CREATE TABLE messages(id INT PRIMARY KEY, {COLUMNS})",
        f"CREATE TABLE messages(id INTEGER PRIMARY KEY, {COLUMNS}) WITHOUT ROWID",
        f"CREATE TABLE kept(id INTEGER PRIMARY KEY, {COLUMNS});"
        "CREATE VIEW messages AS SELECT * FROM kept;"
        "CREATE TRIGGER keep INSTEAD OF INSERT ON messages BEGIN INSERT INTO kept"
        " VALUES (new.id, new.topic_id, new.timestamp, new.data); END",
    ],
)
def test_another_table_of_messages_is_left_to_sqlite(tmp_path: Path, messages: str) -> None:
    rows = rows_of(500)
    found = found_in(make(tmp_path / "a.db3", rows[::-1], messages=messages))
    for number in NUMBERS:
        of_topic = [row for row in rows if row[1] == number]
        assert found[f"t_{number}"] == ([row[2] for row in of_topic], [row[3] for row in of_topic])


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A database of three levels."""
    return make(tmp_path_factory.mktemp("whole") / "a.db3", rows_of(3000))


@pytest.mark.parametrize(
    ("kind", "offset", "damage"),
    [
        (LEAF, 0, b"\x0a"),  # no page of a table
        (LEAF, 3, b"\x00\x00"),  # no cells
        (LEAF, 3, b"\x7f\xff"),  # more cells than the page has room for
        (LEAF, 8, b"\xff\xff"),  # a cell beyond the page
        (LEAF, 8, b"\x00\x08"),  # a cell within the list of cells
        (BRANCH, 3, b"\x00\x00"),
        (BRANCH, 8, b"\x7f\xff\xff\xff"),  # a page beyond the file
        (BRANCH, 8, b"\x00\x00\x00\x01"),  # the page of the schema
        (BRANCH, 8, b"\x00\x00\x00\x03"),  # the first page, which leads to this one
    ],
)
def test_a_damaged_page_is_left_to_sqlite(
    whole: Path, tmp_path: Path, kind: int, offset: int, damage: bytes
) -> None:
    content = bytearray(whole.read_bytes())
    page = [place for place in range(512, len(content), 512) if content[place] == kind][-2]
    content[page + offset : page + offset + len(damage)] = damage
    path = tmp_path / "damaged.db3"
    path.write_bytes(content)
    with pytest.raises(UnusualPagesError):
        by_pages(path)
    assert any("damaged" in problem for problem in read_sqlite(path).problems)


@pytest.mark.parametrize("place", ["size", "types", "id", "order", "end"])
def test_a_damaged_record_is_left_to_sqlite(whole: Path, tmp_path: Path, place: str) -> None:
    content = bytearray(whole.read_bytes())
    page = [place for place in range(512, len(content), 512) if content[place] == LEAF][-2]
    # the second cell: size of the record in one byte, id in two, size of the types, type of the id
    cell = page + int.from_bytes(content[page + 10 : page + 12], "big")
    if place == "order":
        content[page + 8 : page + 12] = content[page + 10 : page + 12] + content[page + 8 : page + 10]
    elif place == "end":
        # the same record, but it would go on in the next page
        content[page + 496 : page + 512] = content[cell : cell + 16]
        content[page + 10 : page + 12] = (496).to_bytes(2, "big")
    else:
        content[cell + {"size": 0, "types": 3, "id": 4}[place]] += 1
    path = tmp_path / "damaged.db3"
    path.write_bytes(content)
    with pytest.raises(UnusualPagesError):
        by_pages(path)


@pytest.mark.parametrize(
    "cell",
    [
        b"\xff\xff\xff\xff",  # a size without an end
        b"\x05\x01\x05\x00\x06\x06\x0c",  # types of numbers for which there is no room
    ],
)
def test_a_record_that_reaches_beyond_the_file_is_left_to_sqlite(
    whole: Path, tmp_path: Path, cell: bytes
) -> None:
    content = bytearray(whole.read_bytes())
    assert content[-512] == LEAF
    content[-512 + 8 : -512 + 10] = (512 - len(cell)).to_bytes(2, "big")
    content[-len(cell) :] = cell
    path = tmp_path / "damaged.db3"
    path.write_bytes(content)
    with pytest.raises(UnusualPagesError):
        by_pages(path)


@pytest.mark.usefixtures("no_rows")
def test_a_transaction_that_was_cut_off_is_taken_back(tmp_path: Path) -> None:
    rows = rows_of(2000)
    path = make(tmp_path / "a.db3", rows)
    with closing(sqlite3.connect(path, isolation_level=None)) as database:
        database.executescript("PRAGMA synchronous = OFF; PRAGMA cache_size = 1; BEGIN")
        database.execute("UPDATE messages SET timestamp = 7, data = zeroblob(8)")
        # what a recorder leaves that is killed now
        (tmp_path / "killed").mkdir()
        for name in ("a.db3", "a.db3-journal"):
            shutil.copy(tmp_path / name, tmp_path / "killed")
        database.execute("ROLLBACK")
    killed = tmp_path / "killed" / "a.db3"
    assert killed.read_bytes() != path.read_bytes()
    before = killed.read_bytes()
    assert found_in(killed) == found_in(path)
    assert killed.read_bytes() == before


@pytest.mark.parametrize(
    "damage",
    [
        "UPDATE topics SET name = NULL WHERE id = 127",
        "UPDATE topics SET type = x'00' WHERE id = 127",
        "UPDATE messages SET data = 'text' WHERE id = 300",
        "UPDATE messages SET timestamp = 0.5 WHERE id = 300",
        "UPDATE messages SET topic_id = 99 WHERE id = 300",
    ],
)
def test_a_value_of_another_kind_is_said_in_one_line(tmp_path: Path, damage: str) -> None:
    topics, messages = TOPICS.replace(" NOT NULL", ""), MESSAGES.replace(" NOT NULL", "")
    path = make(tmp_path / "a.db3", rows_of(500), messages=messages, topics=topics)
    with closing(sqlite3.connect(path)) as database:
        database.execute(damage)
        database.commit()
    problems = read_sqlite(path).problems
    assert [problem for problem in problems if "damaged part" in problem and "\n" not in problem]


def refuse(*_: object) -> None:
    """Do not ask sqlite for the rows."""
    raise UnusualPagesError


@settings(max_examples=100, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(
    # mostly in the heads of pages, where damage is worst
    damage=st.lists(
        st.tuples(st.floats(0, 1), st.integers(0, 40) | st.integers(0, 511), st.integers(0, 255)), max_size=3
    ),
    share=st.just(1.0) | st.floats(0.0, 1.0),
)
@example(damage=[(0.0, 307, 9)], share=1.0)  # id is no INTEGER any more
def test_damaged_pages_give_what_sqlite_gives_or_nothing(
    whole: Path, tmp_path: Path, damage: list[tuple[float, int, int]], share: float
) -> None:
    content = bytearray(whole.read_bytes())
    pages = len(content) // 512
    for page, offset, value in damage:
        place = 512 * int(page * (pages - 1)) + offset
        content[max(place, 16)] = value
    path = tmp_path / "damaged.db3"
    path.write_bytes(content[: max(16, int(share * len(content)))])
    with contextlib.suppress(InputError):
        read_sqlite(path)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sqlite_reading, "_take_rows", refuse)
        try:
            content = read_sqlite(path)
        except (UnusualPagesError, InputError):
            return
    if any("damaged" in problem for problem in content.problems):
        return
    with closing(sqlite3.connect(f"file:{path}?immutable=1", uri=True)) as database:
        database.execute("PRAGMA writable_schema = ON")
        topics = database.execute("SELECT id, name FROM topics").fetchall()
        rows = database.execute("SELECT topic_id, timestamp, data FROM messages ORDER BY id").fetchall()
    for number, name in topics:
        of_topic = [row for row in rows if row[0] == number]
        stamps, messages = content.blocks[topic_name(name)].joined()
        assert stamps == [row[1] for row in of_topic]
        assert messages == [row[2] for row in of_topic]

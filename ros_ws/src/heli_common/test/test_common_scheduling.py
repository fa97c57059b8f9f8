"""Keeping the cores awake: asked for under real-time scheduling, given back, and no error where refused."""

import os
from pathlib import Path

import pytest

from heli_common.nodes import scheduling
from heli_common.nodes.scheduling import Awake


@pytest.fixture
def request_file(tmp_path, monkeypatch):
    file = tmp_path / "cpu_dma_latency"
    file.touch()
    monkeypatch.setattr(scheduling, "LATENCY_REQUEST", file)
    return file


@pytest.fixture
def real_time(monkeypatch):
    monkeypatch.setattr(os, "sched_getscheduler", lambda _: os.SCHED_FIFO)


def is_open(file):
    return str(file) in {os.path.realpath(link) for link in Path("/proc/self/fd").iterdir()}


@pytest.mark.usefixtures("real_time")
def test_the_request_stands_for_as_long_as_it_is_held(request_file):
    awake = Awake()
    assert awake.held
    assert request_file.read_bytes() == bytes(4)  # 0 us
    assert is_open(request_file)
    awake.end()
    awake.end()
    assert not awake.held
    assert not is_open(request_file)


def test_under_ordinary_scheduling_nothing_is_asked_for(request_file):
    assert not Awake().held
    assert request_file.read_bytes() == b""


@pytest.mark.usefixtures("real_time")
def test_a_machine_without_such_a_file_is_no_error(request_file):
    request_file.unlink()
    assert not Awake().held

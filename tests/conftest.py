"""Whole-graph tests: real processes, the real middleware, a domain of its own for each test."""

import itertools
import os
import signal
import subprocess
import sys
from threading import Event
from time import monotonic

import pytest

PATIENCE = 90.0


def domains():
    """ROS domains in turn; HELI_TEST_DOMAINS=FIRST-LAST keeps tests that run beside others apart."""
    first, _, last = os.environ.get("HELI_TEST_DOMAINS", "1-90").partition("-")
    mine = range(int(first), int(last) + 1)
    return (mine[number % len(mine)] for number in itertools.count(os.getpid()))


_DOMAINS = domains()


class Heli:
    """Runs the `heli` command in one ROS domain and one folder."""

    def __init__(self, folder, domain):
        self.folder = folder
        self.environment = os.environ | {
            "ROS_DOMAIN_ID": str(domain),
            "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        }
        self._started = []

    def __call__(self, *words, patience=PATIENCE):
        """Run to the end."""
        return subprocess.run(
            self._words(words),
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=patience,
            check=False,
        )

    def start(self, *words):
        """Start and go on."""
        return self.start_process(*self._words(words))

    def start_process(self, *command):
        """Start another program in the same domain."""
        process = subprocess.Popen(
            command,
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._started.append(process)
        return process

    def close(self):
        """Leave nothing behind."""
        for process in self._started:
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
                try:
                    process.wait(5.0)
                except subprocess.TimeoutExpired:
                    process.kill()
            process.communicate()

    @staticmethod
    def _words(words):
        return [sys.executable, "-m", "heli_flight.cli.main", *words]


@pytest.fixture
def heli(tmp_path):
    """The command, in a folder and a ROS domain that no other test uses."""
    runner = Heli(tmp_path, next(_DOMAINS))
    yield runner
    runner.close()


@pytest.fixture(scope="module")
def shared_heli(tmp_path_factory):
    """The same for what several tests of a module need."""
    runner = Heli(tmp_path_factory.mktemp("shared"), next(_DOMAINS))
    yield runner
    runner.close()


@pytest.fixture
def wait_for():
    """Waits for a condition with a deadline; returns its value."""

    def wait(condition, seconds=PATIENCE, pause=0.05):
        deadline = monotonic() + seconds
        idle = Event()
        while not (value := condition()):
            assert monotonic() < deadline, f"waited {seconds} s in vain"
            idle.wait(pause)
        return value

    return wait

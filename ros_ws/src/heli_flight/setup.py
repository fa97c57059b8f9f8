"""Installs heli_flight (ament_python; plain pip works too)."""

from setuptools import find_packages, setup

setup(
    name="heli_flight",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_dir={"": "."},
    package_data={"heli_flight": ["py.typed", "plans/*.yaml", "templates/*"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/heli_flight"]),
        ("share/heli_flight", ["package.xml"]),
    ],
    python_requires=">=3.10,<3.14",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": [
            "heli = heli_flight.cli.main:main",
            "supervisor_node = heli_flight.nodes.supervisor_node:main",
            "recorder_node = heli_flight.nodes.recorder_node:main",
            "replay_node = heli_flight.nodes.replay_node:main",
        ]
    },
)

"""Installs heli_common (ament_python; plain pip works too)."""

from setuptools import find_packages, setup

setup(
    name="heli_common",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_dir={"": "."},
    package_data={"heli_common": ["py.typed", "nodes/fastdds.xml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/heli_common"]),
        ("share/heli_common", ["package.xml"]),
    ],
    python_requires=">=3.10,<3.14",
    extras_require={"test": ["pytest"]},
    entry_points={},
)

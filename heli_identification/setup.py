"""Installs heli_identification (ament_python; plain pip works too)."""

from setuptools import find_packages, setup

setup(
    name="heli_identification",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_dir={"": "."},
    package_data={"heli_identification": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/heli_identification"]),
        ("share/heli_identification", ["package.xml"]),
    ],
    python_requires=">=3.10,<3.14",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": ["identification_node = heli_identification.nodes.identification_node:main"]
    },
)

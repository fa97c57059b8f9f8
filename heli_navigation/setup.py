"""Installs heli_navigation (ament_python; plain pip works too)."""

from setuptools import find_packages, setup

setup(
    name="heli_navigation",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_dir={"": "."},
    package_data={"heli_navigation": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/heli_navigation"]),
        ("share/heli_navigation", ["package.xml"]),
    ],
    python_requires=">=3.10,<3.14",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": [
            "navigation_node = heli_navigation.nodes.navigation_node:main",
        ]
    },
)

"""Installs heli_control (ament_python; plain pip works too)."""

from setuptools import find_packages, setup

setup(
    name="heli_control",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_dir={"": "."},
    package_data={"heli_control": ["py.typed", "controllers/*.yaml", "weights/*.yaml"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/heli_control"]),
        ("share/heli_control", ["package.xml"]),
    ],
    python_requires=">=3.10,<3.14",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": [
            "motor_controller_node = heli_control.nodes.motor_controller_node:main",
            "position_controller_node = heli_control.nodes.position_controller_node:main",
            "attitude_controller_node = heli_control.nodes.attitude_controller_node:main",
        ]
    },
)

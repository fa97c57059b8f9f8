"""Installs heli_bench_sim (ament_python; plain pip works too)."""

from setuptools import find_packages, setup

setup(
    name="heli_bench_sim",
    version="0.1.0",
    packages=find_packages(exclude=["test"]),
    package_dir={"": "."},
    package_data={"heli_bench_sim": ["py.typed"]},
    data_files=[
        ("share/ament_index/resource_index/packages", ["resource/heli_bench_sim"]),
        ("share/heli_bench_sim", ["package.xml"]),
    ],
    python_requires=">=3.10,<3.14",
    extras_require={"test": ["pytest"]},
    entry_points={
        "console_scripts": [
            "bench_sim_node = heli_bench_sim.nodes.bench_sim_node:main",
        ]
    },
)

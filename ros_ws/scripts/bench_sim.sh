#!/usr/bin/env bash
# The simulated test bench: helicopter, rig, sensors and actuators.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_bench_sim.nodes.bench_sim_node "$@"

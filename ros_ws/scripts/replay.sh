#!/usr/bin/env bash
# Replay a recorded bag to the nodes.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_flight.nodes.replay_node "$@"

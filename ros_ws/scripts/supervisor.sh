#!/usr/bin/env bash
# The supervisor: takes the bench through a flight and stops it when something is wrong.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_flight.nodes.supervisor_node "$@"

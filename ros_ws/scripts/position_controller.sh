#!/usr/bin/env bash
# The position controller: follows the flight plan with a velocity reference.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_control.nodes.position_controller_node "$@"

#!/usr/bin/env bash
# The motor controller: holds the rotor speed.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_control.nodes.motor_controller_node "$@"

#!/usr/bin/env bash
# The attitude controller: follows the velocity reference with the servos.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_control.nodes.attitude_controller_node "$@"

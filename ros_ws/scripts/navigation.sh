#!/usr/bin/env bash
# Navigation: position, velocity and attitude from the encoders.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_navigation.nodes.navigation_node "$@"

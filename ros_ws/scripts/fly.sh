#!/usr/bin/env bash
# Fly a plan with all nodes (hover_steps without arguments); arguments go to "heli fly".
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
(($#)) || set -- hover_steps
run heli fly "$@"

#!/usr/bin/env bash
# Fly the thesis's experiments with all its controllers and compare; arguments go to "heli reproduce".
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
(($#)) || set -- --out reproduction
run heli reproduce "$@"

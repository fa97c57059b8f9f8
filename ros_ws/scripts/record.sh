#!/usr/bin/env bash
# Record every topic of the bench into a rosbag2 bag.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_flight.nodes.recorder_node "$@"

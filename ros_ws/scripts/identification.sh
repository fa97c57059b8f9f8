#!/usr/bin/env bash
# Identification: excites the flying helicopter and estimates its coefficients while it flies.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"
run python -m heli_identification.nodes.identification_node "$@"

# Sourced by every script here: where the project is and what its programs find in their environment.
# shellcheck shell=bash
set -euo pipefail

HELI_SCRIPTS=$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")
HELI_ROOT=$(dirname -- "$(dirname -- "$HELI_SCRIPTS")")
HELI_VENV=$(realpath -ms -- "${HELI_VENV:-$HELI_ROOT/.venv}")
export HELI_ROOT HELI_VENV HELI_SCRIPTS

# Another ROS or another venv may be active in the calling shell; its libraries must not mix with ours.
if [[ ${AMENT_PREFIX_PATH:-$HELI_VENV} != "$HELI_VENV" || -n ${_ROS_WHEELS_BOOTSTRAP_COMPLETE:-} ]]; then
    unset LD_LIBRARY_PATH
fi
unset PYTHONPATH PYTHONHOME _ROS_WHEELS_BOOTSTRAP_COMPLETE COLCON_PREFIX_PATH CMAKE_PREFIX_PATH
export AMENT_PREFIX_PATH=$HELI_VENV RMW_IMPLEMENTATION=rmw_fastrtps_cpp

export ROS_AUTOMATIC_DISCOVERY_RANGE=${ROS_AUTOMATIC_DISCOVERY_RANGE:-LOCALHOST}
export RCUTILS_COLORIZED_OUTPUT=${RCUTILS_COLORIZED_OUTPUT:-1}
export OPENBLAS_NUM_THREADS=1

# Set up if need be, then become the given program of the venv, so that signals reach it.
run() {
    "$HELI_SCRIPTS/setup.sh" || exit
    export VIRTUAL_ENV=$HELI_VENV PATH=$HELI_VENV/bin:$PATH PYTHONSAFEPATH=1
    exec "$HELI_VENV/bin/$1" "${@:2}"
}

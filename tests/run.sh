#!/usr/bin/env bash
# All checks of the project; with arguments only pytest, which gets them: tests/run.sh -k inflow
# Two checks run at a time, so that both cores are busy: those that need no compiled code while set-up compiles, then
# the packages' own tests beside those of the whole graph. The tests marked `alone`, flights in real time, come last.
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../ros_ws/scripts/_environment.sh"
cd -- "$HELI_ROOT"
if (($#)); then
    ros_ws/scripts/setup.sh --dev
else
    ros_ws/scripts/setup.sh --dev --no-kernels
fi
export VIRTUAL_ENV=$HELI_VENV PATH=$HELI_VENV/bin:$PATH RCUTILS_COLORIZED_OUTPUT=0

if (($#)); then
    exec python -m pytest "$@"
fi

said=$(mktemp -d)
trap 'rm -rf -- "$said"' EXIT
touch "$said/failed"

# Run a check to its end, then print all that it said at once. Bash has what it puts into the background ignore SIGINT.
check() { # NAME COMMAND...
    local code=0 began=$SECONDS
    env --default-signal=INT "${@:2}" </dev/null >"$said/$1" 2>&1 || code=$?
    ((!code)) || echo "$1" >>"$said/failed"
    flock "$said/failed" cat - "$said/$1" <<<$'\n'"== $1 ($((SECONDS - began)) s)"
}
# The same beside the other one that runs, once there are less than two.
beside() {
    while (($(jobs -rp | wc -l) > 1)); do wait -n; done
    check "$@" &
}
# Pytest with nine ROS domains that no other one here uses.
domains=1
tests() { # NAME ARGUMENTS...
    HELI_TEST_DOMAINS=$domains-$((domains + 8)) beside "$1" python -m pytest "${@:2}"
    domains=$((domains + 9))
}
modules=(heli_common heli_bench_sim heli_navigation heli_control heli_identification heli_flight)

beside kernels ros_ws/scripts/setup.sh --dev
kernels=$!
beside lint ruff check
beside format ruff format --check
beside types mypy "${modules[@]/#/-p}"
tests control heli_control
wait "$kernels"
tests graph -m "not alone" --durations=12 tests
tests flight --durations=12 ros_ws/src/heli_flight
tests bench heli_bench_sim
tests navigation heli_navigation
tests identification heli_identification ros_ws/src/heli_common
wait
check alone python -m pytest -m alone --durations=12 tests
mapfile -t failed <"$said/failed"
((!${#failed[@]})) || { echo "failed: ${failed[*]}" && exit 1; }

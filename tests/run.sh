#!/usr/bin/env bash
# All checks of the project; with arguments only pytest, which gets them: tests/run.sh -k inflow
# Two checks run at a time, so that both cores are busy: those that need no compiled code while set-up compiles, then
# the tests. Beside those marked `alone`, flights in real time, others get only what these leave of the processor.
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

# Run a check to its end, then print all that it said. What bash puts into the background would not hear Ctrl-C.
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
tests() { # NAME DOMAINS ARGUMENTS...
    HELI_TEST_DOMAINS=$2 beside "$1" python -m pytest "${@:3}"
}
idly() { # NAME ARGUMENTS...
    beside "$1" chrt --idle 0 python -m pytest "${@:2}"
}
modules=(heli_common heli_bench_sim heli_navigation heli_control heli_identification heli_flight)
ways=(tests/test_{ways_of_running,side_by_side,live_graph,refusals}.py)

beside kernels ros_ws/scripts/setup.sh --dev
kernels=$!
beside lint ruff check
beside format ruff format --check
beside types mypy "${modules[@]/#/-p}"
beside control python -m pytest heli_control
wait "$kernels"
idly flight --durations=12 ros_ws/src/heli_flight
tests alone 1-30 -m alone --durations=12 tests
alone=$!
idly bench heli_bench_sim
wait "$alone"
tests ways 31-60 -m "not alone" --durations=12 "${ways[@]}"
tests graph 61-90 -m "not alone" --durations=12 tests "${ways[@]/#/--ignore=}"
beside navigation python -m pytest heli_navigation
beside identification python -m pytest heli_identification ros_ws/src/heli_common
wait
mapfile -t failed <"$said/failed"
((!${#failed[@]})) || { echo "failed: ${failed[*]}" && exit 1; }

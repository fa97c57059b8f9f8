#!/usr/bin/env bash
# All checks of the project; with arguments only pytest, which gets them: tests/run.sh -k inflow
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/../ros_ws/scripts/_environment.sh"
cd -- "$HELI_ROOT"
ros_ws/scripts/setup.sh --dev
export VIRTUAL_ENV=$HELI_VENV PATH=$HELI_VENV/bin:$PATH RCUTILS_COLORIZED_OUTPUT=0

if (($#)); then
    exec python -m pytest "$@"
fi

failed=()
check() {
    printf '\n== %s\n' "$1"
    "${@:2}" || failed+=("$1")
}
check lint ruff check
check format ruff format --check
check types mypy -p heli_common -p heli_bench_sim -p heli_navigation -p heli_control -p heli_identification -p heli_flight
check tests python -m pytest
((!${#failed[@]})) || { echo "failed: ${failed[*]}" && exit 1; }

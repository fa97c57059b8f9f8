#!/usr/bin/env bash
# All checks of the project; with arguments only pytest, which gets them: tests/run.sh -k inflow
# Two cores are kept busy: one half of the packages' own tests runs beside lint, types and the other half. The tests
# of the whole graph come last and have the machine to themselves, for some of them are flights in real time.
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
said=$(mktemp)
trap 'rm -f -- "$said"' EXIT
python -m pytest heli_bench_sim heli_navigation heli_identification >"$said" 2>&1 &
beside=$!
check lint ruff check
check format ruff format --check
check types mypy -p heli_common -p heli_bench_sim -p heli_navigation -p heli_control -p heli_identification -p heli_flight
check packages python -m pytest heli_control ros_ws/src/heli_common ros_ws/src/heli_flight
wait "$beside" || failed+=("packages beside")
printf '\n== packages beside\n'
cat -- "$said"
check graph python -m pytest --durations=12 tests
((!${#failed[@]})) || { echo "failed: ${failed[*]}" && exit 1; }

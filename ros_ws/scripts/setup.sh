#!/usr/bin/env bash
# Make the project's own Python environment, or find within milliseconds that it is complete.
#
#   setup.sh          what flying needs     (requirements.txt)
#   setup.sh --dev    and what testing needs (requirements-dev.txt; a browser, if apt-get may install it)
#   setup.sh --dev --no-kernels   the same, but the flight code is compiled when somebody asks without this
#
# It lands in .venv in the repository, or where HELI_VENV says. HELI_PYTHON names another Python to build it
# with. pip's own variables (PIP_INDEX_URL, ...) are respected. Exit code 2: no usable Python.
[[ ${BASH_SOURCE[0]} == "$0" ]] || { echo "run setup.sh, do not source it" >&2; return 2; }
# shellcheck source=ros_ws/scripts/_environment.sh
source "$(dirname -- "$(readlink -f -- "${BASH_SOURCE[0]}")")/_environment.sh"

say() { printf 'set-up: %s\n' "$*" >&2; }
fail() {
    say "$*"
    exit 2
}

kind=run kernels=1
for word; do
    case $word in
        --dev) kind=dev ;;
        --no-kernels) kernels=0 ;;
        *) fail "unknown arguments: $* (allowed: --dev, --no-kernels)" ;;
    esac
done

python=$HELI_VENV/bin/python
stamp=$HELI_VENV/.heli_setup # lines "run KEY", "dev KEY", "kernels KEY"; a line stands for a completed part
packages=(ros_ws/src/heli_common heli_bench_sim heli_navigation heli_control heli_identification ros_ws/src/heli_flight)
modules=()
for package in "${packages[@]}"; do modules+=("$package/${package##*/}"); done
cache=${HELI_CACHE:-${XDG_CACHE_HOME:-${HOME:-~}/.cache}}/heli_bench
cd -- "$HELI_ROOT"

# SHA-256 over the files named on standard input (ended by NUL) and the given words.
key_of() {
    local sums
    sums=$(xargs -0 sha256sum)
    sums=$(sha256sum <<<"$sums $*")
    printf '%s' "${sums%% *}"
}

# The venv's pyvenv.cfg stands for the version of Python; editable packages tie the venv to this folder.
install_key() {
    local files=("$HELI_SCRIPTS/setup.sh" requirements.txt "${packages[@]/%//setup.py}")
    [[ $1 == run ]] || files+=(requirements-dev.txt)
    printf '%s\0' "${files[@]}" "$HELI_VENV/pyvenv.cfg" | key_of "$HELI_ROOT"
}
kernels_key() { find "${modules[@]}" -name '*.py' -print0 | sort -z | key_of "$cache"; }

stamped() { [[ -f $stamp && $'\n'$(<"$stamp")$'\n' == *$'\n'"$1 $2"$'\n'* ]]; }
installed() { [[ -x $python && -f $HELI_VENV/pyvenv.cfg ]] && stamped "$kind" "$(install_key "$kind")"; }
compiled() { ((!kernels)) || { [[ -d $cache ]] && stamped kernels "$(kernels_key)"; }; }

# A venv whose set-up broke off (an empty stamp) or whose Python is gone is made afresh; any other is updated.
usable() { [[ -f $HELI_VENV/pyvenv.cfg && (-s $stamp || ! -f $stamp) ]] && "$python" -c '' 2>/dev/null; }

# Print the Python to build with: CPython 3.10 to 3.13 that can make a venv.
find_python() {
    local candidate version without_venv=
    local candidates=(python3 python3.13 python3.12 python3.11 python3.10)
    [[ -z ${HELI_PYTHON:-} ]] || candidates=("$HELI_PYTHON")
    for candidate in "${candidates[@]}"; do
        version=$("$candidate" -c '
import sys, sysconfig
good = sys.implementation.name == "cpython" and (3, 10) <= sys.version_info < (3, 14)
good = good and not sysconfig.get_config_var("Py_GIL_DISABLED")
print("%d.%d" % sys.version_info[:2] if good else "")' 2>/dev/null) || continue
        [[ -n $version ]] || continue
        if "$candidate" -c 'import ensurepip, venv' 2>/dev/null; then
            echo "$candidate"
            return
        fi
        without_venv=${without_venv:-$version}
    done
    [[ -z $without_venv ]] || fail "Python $without_venv has no venv module: apt install python$without_venv-venv"
    fail "needs CPython 3.10 to 3.13, found none: apt install python3 python3-venv"
}

make_venv() {
    local base
    base=$(find_python)
    if [[ -f $stamp ]]; then # ours, and broken off or broken since
        find "$HELI_VENV" -mindepth 1 ! -name '.heli_*' -delete
    fi
    : >"$stamp"
    say "making $HELI_VENV with $("$base" -V)"
    "$base" -m venv -- "$HELI_VENV"
}

install() {
    local requirements=requirements.txt first
    [[ $kind == run ]] || requirements="requirements-dev.txt"
    : >"$stamp"
    say "installing $requirements (a minute, once)"
    # The files are complete, so pip has nothing to resolve, which old versions of it get wrong with extras. One
    # package comes as source only: it is built with the pinned setuptools, not with the newest there is.
    local pip=("$python" -m pip --disable-pip-version-check --quiet install --no-deps --no-compile)
    first=$(awk '/^setuptools==/ {on = 1} on {print} on && !/\\$/ {exit}' "$requirements")
    "${pip[@]}" --require-hashes -r /dev/stdin <<<"$first"
    pip+=(--no-build-isolation --use-pep517)
    "${pip[@]}" --require-hashes -r "$requirements"
    say "installing the six packages"
    "${pip[@]}" "${packages[@]/#/--editable=./}"
    # Bytecode of what will be imported, on every core: pip would write that of the packages' tests, too, on one.
    "$python" -m compileall -q -j 0 -x '/tests?/' "$HELI_VENV/lib" >/dev/null || say "some bytecode is missing"
    register
    {
        echo "run $(install_key run)"
        [[ $kind == run ]] || echo "dev $(install_key dev)"
    } >"$stamp"
}

# The ament index of the venv: `ros2 run`, `ros2 launch` and `ros2 pkg` find the packages without colcon.
register() {
    local package name script
    for package in "${packages[@]}"; do
        name=${package##*/}
        mkdir -p -- "$HELI_VENV"/{share/ament_index/resource_index/packages,"share/$name","lib/$name"}
        : >"$HELI_VENV/share/ament_index/resource_index/packages/$name"
        ln -sfn -- "$HELI_ROOT/$package/package.xml" "$HELI_VENV/share/$name/package.xml"
        while read -r script; do
            ln -sfn -- "../../bin/$script" "$HELI_VENV/lib/$name/$script"
        done < <(grep -o "\"[a-z_]* = $name\." "$package/setup.py" | tr -d '"' | cut -d ' ' -f 1)
    done
}

compile() {
    local key
    key=$(kernels_key)
    say "compiling the flight code"
    "$python" -m heli_flight.warm_up >&2
    mkdir -p -- "$cache"
    sed -i '/^kernels /d' "$stamp"
    echo "kernels $key" >>"$stamp"
}

# The tests open the reports in Chromium, or in what HELI_BROWSER names.
browser() {
    local name
    for name in "${HELI_BROWSER:-chromium}" chromium-browser google-chrome google-chrome-stable; do
        if command -v "$name" >/dev/null; then return; fi
    done
    if ((EUID == 0)) && command -v apt-get >/dev/null; then
        say "installing chromium"
        if apt-get -qq update && DEBIAN_FRONTEND=noninteractive apt-get -qq install chromium; then return; fi
    fi >&2
    say "no browser: the tests that open reports in one will fail (apt install chromium)"
}

if [[ $kind == dev ]]; then browser & fi # beside pip
if installed && compiled; then wait && exit; fi

if [[ -n $(ls -A -- "$HELI_VENV" 2>/dev/null) && ! -f $HELI_VENV/pyvenv.cfg && ! -f $HELI_VENV/.heli_lock ]]; then
    fail "HELI_VENV=$HELI_VENV is a folder with other things in it"
fi

# One set-up at a time; the next one finds the work done. The lock ends with the last process holding it.
mkdir -p -- "$HELI_VENV"
exec {lock}>>"$HELI_VENV/.heli_lock"
flock --nonblock "$lock" || { say "waiting for another set-up" && flock "$lock"; }
if ! installed; then
    usable || make_venv
    install
fi
compiled || compile
wait
say "complete after $SECONDS s"

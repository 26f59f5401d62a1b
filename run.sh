#!/usr/bin/env bash
# Sets up what is missing (system libraries, a virtual environment in .venv) and runs one of:
#   demo [OPTIONS]   the main job on a real mesh: qgeo demo
#   test [OPTIONS]   lint, types and tests; options go to pytest
#   coverage         the tests of the gate, and how much of the code they ran: a quarter longer, so not part of the gate
#   dist             wheel and source distribution, checked, and the wheel used in bare environments: a few minutes
#   oldest [TESTS]   some tests on the lowest versions that pyproject.toml admits, in an environment of their own
#   docs [OPTIONS]   the pages of docs/, into docs/_build/html; options go to Sphinx (-D plot_gallery=0 runs no example)
#   setup EXTRA      only the environment, with this extra of pyproject.toml (all, test, docs)
# PYTHON chooses the interpreter (3.11 to 3.13), VENV the folder of the environment, QGEO_TEST_SEED the order of the tests
# (pytest prints it; `-p no:randomly` runs them as they are written).
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")"
venv=${VENV:-.venv}

find_python() {
    local candidate
    for candidate in ${PYTHON:-} python3.11 python3.12 python3.13 python3; do
        if command -v "$candidate" >/dev/null &&
            "$candidate" -c 'import sys; sys.exit(not (3, 11) <= sys.version_info[:2] <= (3, 13))' 2>/dev/null; then
            echo "$candidate"
            return
        fi
    done
    echo "run.sh: needs Python 3.11, 3.12 or 3.13 (set PYTHON=/path/to/python)" >&2
    exit 2
}

# Open3D loads libusb and libGL, PyMeshLab libOpenGL; a slim image has none of them, nor libgomp and venv.
system_libraries() {
    local python=$1 kind=$2 missing=() library as_root=()
    command -v apt-get >/dev/null || return 0
    for library in libGL.so.1:libgl1 libEGL.so.1:libegl1 libOpenGL.so.0:libopengl0 libusb-1.0.so.0:libusb-1.0-0 \
        libgomp.so.1:libgomp1 libX11.so.6:libx11-6; do
        /sbin/ldconfig -p | grep -q "${library%%:*}" || missing+=("${library##*:}")
    done
    "$python" -c 'import ensurepip, venv' 2>/dev/null || missing+=("$(basename "$(readlink -f "$(command -v "$python")")")-venv")
    if [ "$kind" = test ]; then # the browser tests: chromium, and what playwright's driver loads
        command -v chromium >/dev/null || missing+=(chromium)
        /sbin/ldconfig -p | grep -q libatomic.so.1 || missing+=(libatomic1)
    fi
    [ ${#missing[@]} -gt 0 ] || return 0
    if [ "$(id -u)" != 0 ]; then
        if ! sudo -n true 2>/dev/null; then
            echo "run.sh: system packages are missing; install them with: sudo apt-get install ${missing[*]}" >&2
            exit 2
        fi
        as_root=(sudo)
    fi
    echo "run.sh: installing ${missing[*]}"
    "${as_root[@]}" apt-get update -qq
    DEBIAN_FRONTEND=noninteractive "${as_root[@]}" apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null
}

setup() {
    local extra=$1 python stamp
    python=$(find_python)
    system_libraries "$python" "$extra"
    [ -d "$venv" ] || "$python" -m venv "$venv"
    bin="$venv/bin"
    [ -d "$bin" ] || bin="$venv/Scripts" # Windows
    stamp="$venv/.qgeo-$extra-$("$python" -c 'import zlib; print(zlib.crc32(open("pyproject.toml", "rb").read()))')"
    if [ ! -e "$stamp" ]; then
        echo "run.sh: installing qgeo-filters[$extra] into $venv"
        "$bin/python" -m pip install -q --disable-pip-version-check --no-compile -e ".[$extra]"
        # pip would compile on one core. Some packages bring files that are no Python 3: theirs to tell.
        "$bin/python" -m compileall -qq -j 0 "$venv" || true
        touch "$stamp"
    fi
}

export OPEN3D_DISABLE_WEB_VISUALIZER=true # its web server is not wanted, neither here nor in a kernel
case ${1:-} in
demo)
    shift
    setup all
    exec "$bin/qgeo" demo "$@"
    ;;
test)
    shift
    setup test
    # Kernels are compiled once, on the other core, and not in each test process.
    "$bin/qgeo" warmup >/dev/null &
    warmup=$!
    trap 'kill "$warmup" 2>/dev/null || true' EXIT
    "$bin/ruff" check .
    "$bin/ruff" format --check .
    "$bin/mypy"
    wait "$warmup"
    # Two test processes on two cores: BLAS's own threads would wait for each other by spinning, half of all CPU time.
    export OPENBLAS_NUM_THREADS=1
    order="--randomly-seed=${QGEO_TEST_SEED:-2018}"
    [[ " $* " != *no:randomly* ]] || order=
    exec "$bin/python" -m pytest -n 2 --dist loadfile --no-loadscope-reorder $order "$@"
    ;;
coverage)
    setup test
    export OPENBLAS_NUM_THREADS=1
    "$bin/python" -m pytest -n 2 --dist loadfile --cov --cov-report=
    exec "$bin/python" .ci/coverage_report.py
    ;;
dist)
    shift
    setup all
    "$bin/python" -m pip install -q --disable-pip-version-check "build>=1.2" "twine>=6"
    exec "$bin/python" .ci/distributions.py "$@"
    ;;
oldest)
    shift
    python=$(find_python)
    system_libraries "$python" all
    exec "$python" .ci/oldest.py "$@"
    ;;
docs)
    shift
    setup docs
    export OPENBLAS_NUM_THREADS=1
    exec "$bin/python" -m sphinx -W --keep-going -b html "$@" docs docs/_build/html # -W: no warning is let through
    ;;
setup)
    setup "${2:-all}"
    ;;
*)
    sed -n '2,11s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2
    exit 2
    ;;
esac

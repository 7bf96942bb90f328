# Sourced by every test_*.sh. $1 of the script is the binary, $2 a folder to work in, $3 a program that makes volumes
# (make_volume.cpp); all end up in variables.
set -u
raysweep=$1
work=$2
make_volume=${3:-}
# Real data: see findData in tests/support/volumes.h.
data=${RAYSWEEP_DATA:-$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)/../shared/data}
failures=0

rm -rf "$work" && mkdir -p "$work" && cd "$work" || exit 1

fail() {
    echo "FAIL: $*"
    sed 's/^/    /' "$work/.out" "$work/.err"
    failures=$((failures + 1))
}

# expect_exit CODE COMMAND...: runs it, keeps stdout in .out and stderr in .err.
expect_exit() {
    local expected=$1 code
    shift
    "$@" >"$work/.out" 2>"$work/.err"
    code=$?
    [ "$code" = "$expected" ] || fail "exit $code instead of $expected: $*"
}

# expect_match TEXT: the last command's stderr holds TEXT. expect_output TEXT: its stdout does.
expect_match() { grep -qF -- "$1" "$work/.err" || fail "stderr lacks: $1"; }
expect_output() { grep -qF -- "$1" "$work/.out" || fail "stdout lacks: $1"; }

# expect_silent: the last command wrote nothing to stderr.
expect_silent() { [ ! -s "$work/.err" ] || fail "stderr is not empty"; }

# expect_no_leftovers FOLDER: no temporary of a write that failed.
expect_no_leftovers() {
    local found
    found=$(find "$1" -name '.*.part*')
    [ -z "$found" ] || fail "left behind: $found"
}

# has_itk: this build has ITK, which reads DICOM and writes MetaImage. need_itk: without it the test ends here, as skipped.
has_itk() {
    echo nothing >"$work/.itk.dcm"
    ! "$raysweep" import "$work/.itk.dcm" -o "$work/.itk.vdb" 2>&1 | grep -q "has no ITK"
}
need_itk() {
    has_itk && return
    echo "skipped: this build has no ITK"
    exit 77
}

# json FILE EXPRESSION: evaluates EXPRESSION with r = the document; for checks of numbers.
json() { python3 -c "import json,math,sys; r = json.load(open(sys.argv[1])); print($2)" "$1"; }
expect_json() { [ "$(json "$1" "$2")" = True ] || fail "not true of $1: $2"; }

finish() {
    [ "$failures" = 0 ] && echo "all as expected"
    exit $((failures > 0))
}

# start_interruptible COMMAND...: in the background as from a terminal, output in .out and .err. A script's shell starts what is in
# the background with SIGINT ignored, and what starts so leaves it ignored.
start_interruptible() {
    (trap - INT && exec "$@") >"$work/.out" 2>"$work/.err" &
}

# interrupt_after_work PROCESS: Ctrl-C once it has worked for about a second, however long that takes on a busy machine. Returns its
# exit code.
interrupt_after_work() {
    local ticks=0
    while [ "${ticks:-9999}" -lt "$(getconf CLK_TCK)" ]; do
        sleep 0.1
        ticks=$(awk '{print $14}' "/proc/$1/stat" 2>/dev/null)
    done
    kill -INT "$1"
    wait "$1"
}

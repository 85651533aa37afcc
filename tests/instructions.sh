#!/bin/sh
# Prints how many instructions a cycle of the kinematics core takes for each moving object: a figure that hardly depends on
# what else the machine does.
#
# Usage: tests/instructions.sh [PROGRAM]
#
#   PROGRAM  the program to measure; without it the release build of this checkout, which is brought up to date first.
#
# Environment, with the defaults:
#
#   OBJECTS=4000      how many circles march
#   DENSITY=0.05,0.25 the shares of the area that they cover
#   CYCLES=20         how many cycles are counted
#
# Runs `bench scale` under callgrind, which counts only while a cycle of the march runs (`March::step`), in CYCLES and in twice as many cycles; the
# warm-up is the same in both. Instructions per object and cycle = (those of the longer run - those of the shorter one) /
# (CYCLES * OBJECTS). The count depends on the compiler, on the libraries and on what the processor can do: compare it with
# that of another commit on the same machine.
#
# Needs valgrind (https://valgrind.org; in the packages of most systems). Takes ten seconds, and the build.
set -eu

objects=${OBJECTS:-4000}
densities=${DENSITY:-0.05,0.25}
cycles=${CYCLES:-20}
step='*bench::march::March*::step'

fail() {
    echo "instructions.sh: $*" >&2
    exit 1
}

command -v valgrind >/dev/null 2>&1 ||
    fail "valgrind is not installed or not in PATH; install the package valgrind and try again"

if [ $# -gt 0 ]; then
    program=$1
else
    cd "$(dirname "$0")/.."
    cargo build --quiet --release --package maniple-cli
    program=${CARGO_TARGET_DIR:-target}/release/maniple
fi
[ -x "$program" ] || fail "$program is not a program"

log=$(mktemp)
trap 'rm -f "$log"' EXIT

# The instructions of a density and a number of cycles.
count() {
    valgrind --tool=callgrind --callgrind-out-file=/dev/null --toggle-collect="$step" "$program" bench scale \
        --objects "$objects" --density "$1" --threads 1 --cycles "$2" --json >/dev/null 2>"$log" || {
        cat "$log" >&2
        fail "the run under valgrind failed"
    }
    counted=$(sed -n 's/^==[0-9]*== Collected : //p' "$log")
    [ "${counted:-0}" -gt 0 ] || fail "callgrind has counted nothing: $program has no function $step"
    echo "$counted"
}

printf '%9s %7s %29s\n' objects density 'instructions/object and cycle'
for density in $(echo "$densities" | tr ',' ' '); do
    short=$(count "$density" "$cycles")
    long=$(count "$density" $((2 * cycles)))
    printf '%9s %7s %29s\n' "$objects" "$density" $(((long - short) / (cycles * objects)))
done

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Fuzzes: run.sh SECONDS [TARGET...], each target for so long, two at a time. Installs what is missing (Debian), builds
# into build-fuzz and prints a table. Fails where an input crashes, hangs or takes too much memory; such inputs lie in
# build-fuzz/data/crashes. The corpora stay in build-fuzz/data, so that a later run goes on from there.
set -eu
cd "$(dirname "$0")/../.."
[ $# -gt 0 ] || { echo "usage: sh tests/fuzz/run.sh SECONDS [TARGET...]" >&2; exit 2; }
seconds=$1
shift
targets=${*:-$(ls tests/fuzz/seeds)}

. tests/packages.sh
install_missing $BUILD_PACKAGES $CLANG_PACKAGES
cmake --preset fuzz $BY_CLANG >/dev/null
cmake --build build-fuzz

data=build-fuzz/data
rm -rf "$data/log" "$data/crashes"
mkdir -p "$data/log"
export ASAN_OPTIONS=allocator_may_return_null=1:quarantine_size_mb=16
export UBSAN_OPTIONS=print_stacktrace=1
export OMP_NUM_THREADS=1

# Inputs stay small: what matters of a format fits, and larger ones are slower. A network doesn't fit.
longest() {
    case $1 in
    weights) echo 120000 ;;
    xml | gltf) echo 16384 ;;
    *) echo 4096 ;;
    esac
}

fuzz() {
    dictionary=""
    [ -f "tests/fuzz/dictionaries/$1.dict" ] && dictionary="-dict=tests/fuzz/dictionaries/$1.dict"
    found=""
    [ -d "tests/fuzz/found/$1" ] && found="tests/fuzz/found/$1"
    mkdir -p "$data/$1" "$data/crashes/$1"
    "build-fuzz/fuzz_$1" -max_total_time="$seconds" -max_len="$(longest "$1")" -timeout=30 -rss_limit_mb=2048 \
        -malloc_limit_mb=512 -print_final_stats=1 -artifact_prefix="$data/crashes/$1/" $dictionary \
        "$data/$1" "tests/fuzz/seeds/$1" $found >"$data/log/$1-run.log" 2>&1 || echo "fuzz_$1: exit code $?"
}

set -- $targets
while [ $# -gt 0 ]; do
    fuzz "$1" &
    [ $# -gt 1 ] && { fuzz "$2" & shift; }
    shift
    wait
done
find "$data/crashes" -type f
sh tests/fuzz/sum.sh "$data/log"

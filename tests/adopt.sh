#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Does what people do who adopt fewray: each of tests/adopt/NAME.sh begins with the tree alone, installs the packages that it
# needs, builds into build-adopt/NAME and ends with 0 where its promise holds.
#     sh tests/adopt.sh [NAME...]    all of them if none is named
# Exit code 77 of one: it was skipped, since PyTorch couldn't be had from PyPI.
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- $(ls tests/adopt | sed -n 's/\.sh$//p')
failed="" skipped=""
for name in "$@"; do
    echo "== $name"
    code=0
    sh "tests/adopt/$name.sh" || code=$?
    case $code in
    0) ;;
    77) skipped="$skipped $name" ;;
    *) failed="$failed $name" ;;
    esac
done
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }
echo "done: $*${skipped:+; skipped of these:$skipped}"

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Does what people do who adopt fewray: each of tests/adopt/NAME.sh begins with the tree alone, installs the packages that it
# needs, builds into build-adopt/NAME and ends with 0 where its promise holds.
#     sh tests/adopt.sh [NAME...]    all of them if none is named
set -eu
cd "$(dirname "$0")/.."
[ $# -gt 0 ] || set -- $(ls tests/adopt | sed -n 's/\.sh$//p')
failed=""
for name in "$@"; do
    echo "== $name"
    sh "tests/adopt/$name.sh" || failed="$failed $name"
done
[ -z "$failed" ] || { echo "failed:$failed" >&2; exit 1; }
echo "all done: $*"

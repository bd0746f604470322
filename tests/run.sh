#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing (Debian), builds into build/ and runs every test.
set -eu
cd "$(dirname "$0")/.."
. tests/packages.sh
install_missing $BUILD_PACKAGES $TEST_PACKAGES

cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEWRAY_TESTS=ON
cmake --build build
ctest --test-dir build --output-on-failure

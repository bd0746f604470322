#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# `pip install .` in a fresh virtual environment with Debian's numpy, without network, and what the package promises.
set -eu
. tests/packages.sh
install_missing $BUILD_PACKAGES python3-venv python3-numpy mypy
folder=$PWD/build-adopt/python
mkdir -p "$folder"
"${PYTHON:-/usr/bin/python3}" -m venv --system-site-packages --clear "$folder/venv"
"$folder/venv/bin/pip" install --quiet --no-index --force-reinstall --no-deps .
cmake --build build-python --target fewray >/dev/null
cd "$folder" # not the tree, whose folders Python would find
FEWRAY=$OLDPWD/build-python/fewray TREE=$OLDPWD "$folder/venv/bin/python" "$OLDPWD/tests/adopt/test_python.py"

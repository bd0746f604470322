#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Both networks can be trained anew from nothing, in the size that docs/how-it-works.md calls tiny, and used.
set -eu
. tests/packages.sh
install_missing python3 python3-venv
. denoise/train/retrain_setup.sh
export RETRAIN_VENV="$PWD/build-adopt/venv"
(make_environment) || exit 77
tree=build-adopt/retrain
rm -rf $tree
mkdir -p $tree
tar --exclude='./build*' --exclude=./.git --exclude=./examples/out -cf - . | tar -xf - -C $tree
cd $tree
python3 tests/adopt/documents.py --run-by tests/adopt/retrain.sh docs/how-it-works.md
cat build-retrain/tiny-*/errors.txt
# A trained network is better than none.
awk '/^path tracing/ { none = $NF } /^guided, new/ { new = $NF } END { exit !(new > 0 && new < none) }' build-retrain/tiny-guide/errors.txt
awk '/^noisy/ { none = $NF } /new network/ { new = $NF } END { exit !(new > 0 && new < none) }' build-retrain/tiny-denoise/errors.txt

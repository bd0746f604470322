#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Every command of the documents runs: README.md, docs/*.md and the README.md of folders, block by block, in a copy of the tree that
# has a build. Every link in them leads somewhere, every option is one of the program's, every field of a file is described.
#     sh tests/adopt/documents.sh [FILE.md...]    all if none is named
# documents.py tells how a block is marked that isn't run here. Stand-ins for the placeholders in the documents, made beforehand:
#     scene.xml SCENE.xml            examples/cornell-box.xml at 96 x 96 pixels
#     model.glb                      examples/lamp.gltf, small
#     reference.exr REFERENCE.exr    scene.xml at 256 samples a pixel, with its standard errors
#     passes.exr                     scene.xml noisy, with its direct and indirect light
#     part-1.exr ... part-10.exr     ten parts of scene.xml
#     OTHER/room/scene-diffuse.xml   scene.xml, another scene to train with
set -eu
. tests/packages.sh
install_missing $BUILD_PACKAGES $TEST_PACKAGES python3 python3-venv patch
. denoise/train/retrain_setup.sh
RETRAIN_VENV=$PWD/build-adopt/venv
tree=$PWD/build-adopt/documents
rm -rf "$tree"
mkdir -p "$tree"
(make_environment) || exit 77 # with PyTorch, for the training's commands
tar --exclude='./build*' --exclude=./.git --exclude=./examples/out -cf - . | tar -xf - -C "$tree"
here=$PWD
cd "$tree"
cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEWRAY_TESTS=OFF >build.log
cmake --build build >>build.log || { tail -n 40 build.log; exit 1; }

sed 's/\(name="\(width\|height\)" value="\)[0-9]*/\196/' examples/cornell-box.xml >scene.xml
cp scene.xml SCENE.xml
mkdir -p OTHER/room
cp scene.xml OTHER/room/scene-diffuse.xml
python3 "$here/tests/adopt/documents_glb.py" examples/lamp.gltf model.glb
build/fewray render scene.xml --spp 256 --seed 7 --denoise off --float -o many.exr
python3 tests/adopt/documents_reference.py many.exr reference.exr
cp reference.exr REFERENCE.exr
build/fewray render scene.xml --denoise off --aovs direct,indirect -o passes.exr
for part in 1 2 4 5 6 7 8 9 10; do
    build/fewray render scene.xml --part $part/10 --spp 16 -o part-$part.exr
done

status=0
python3 tests/adopt/documents_check.py || status=1
PATH="$RETRAIN_VENV/bin:$PATH" python3 tests/adopt/documents.py "$@" || status=1
exit $status

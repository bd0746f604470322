#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Installs what is missing (Debian), builds into build/, renders a scene of ours at 4 samples a pixel, guided and denoised,
# and draws before and after; then its direct and indirect light, each denoised by the picture's own kernels.
set -eu
cd "$(dirname "$0")/.."
. tests/packages.sh
install_missing $BUILD_PACKAGES

cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEWRAY_TESTS=OFF
cmake --build build --target fewray example-sum_of_layers

out=examples/out
mkdir -p "$out"
build/fewray render examples/door-ajar.xml --spp 4 -o "$out/door-ajar.exr" --png "$out/door-ajar.png" \
    --stats "$out/door-ajar.json"
build/fewray composite "$out/door-ajar.exr" "$out/door-ajar.exr" --caption "door-ajar" --stats "$out/door-ajar.json" \
    -o "$out/door-ajar-before-after.png"

build/fewray render examples/door-ajar.xml --spp 4 --denoise off --aovs direct,indirect --float -o "$out/parts.exr"
build/fewray denoise "$out/parts.exr" --aov direct,indirect --float -o "$out/parts-denoised.exr"
build/example-sum_of_layers "$out/parts-denoised.exr" direct indirect

echo "the picture with its layers:  $out/door-ajar.exr, and as PNG $out/door-ajar.png"
echo "before and after:             $out/door-ajar-before-after.png"
echo "direct and indirect light:    $out/parts-denoised.exr"
echo "seconds and counts:           $out/door-ajar.json"

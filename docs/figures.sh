#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Draws the pictures of how-it-works.md anew, from the tree alone: installs packages, builds, renders.
#     sh docs/figures.sh [FOLDER]    FOLDER gets the PNGs and numbers.txt; docs/ if not given
# FIGURE_SAMPLES=N: samples a pixel of references and of each bin of true maps (1024).
set -eu
cd "$(dirname "$0")/.."
. tests/packages.sh
install_missing $BUILD_PACKAGES
out=${1:-docs}
samples=${FIGURE_SAMPLES:-1024}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
mkdir -p "$out"

cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release >"$work/log"
cmake --build build --target fewray fewray-draw-map example-draw_kernel >"$work/log"
room=examples/door-ajar.xml
: >"$work/numbers.txt"

echo "maps"
map="build/fewray-draw-map --width 448 --samples $samples"
$map --pixel 200,200 -o "$out/map-ball.png" $room >>"$work/numbers.txt"
$map --pixel 60,190 -o "$out/map-wall.png" $room >>"$work/numbers.txt"

echo "noise"
render="build/fewray render $room --width 320 --denoise off"
$render --spp $samples --seed 99 -o "$work/reference.exr" --png "$out/noise-reference.png"
$render --guide off -o "$work/plain.exr" --png "$out/noise-plain.png"
$render -o "$work/guided.exr" --png "$out/noise-guided.png"
for kind in plain guided; do
    build/fewray compare "$work/$kind.exr" "$work/reference.exr" | sed -n "s/^mrse:/mrse, $kind, 4 samples a pixel:/p" \
        >>"$work/numbers.txt"
done

echo "kernels"
build/fewray render $room --width 448 --denoise off -o "$work/noisy.exr"
build/example-draw_kernel "$work/noisy.exr" "$out/kernels.png" 60,60 200,200 380,215 >>"$work/numbers.txt"

cp "$work/numbers.txt" "$out/numbers.txt"
cat "$out/numbers.txt"

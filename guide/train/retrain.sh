#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The guide's network in one command from nothing: packages, PyTorch, build, scenes, maps, training, weights, an error figure.
#     sh guide/train/retrain.sh [--tiny] [OUT]     OUT: build-retrain/guide
# --tiny goes through all of it in three minutes beside the build; such a network is no good. An interrupted run goes on. README.md
# beside this file tells what each step does. Leaves OUT/odis.bin, OUT/errors.txt and OUT/guided.png.
set -eu
cd "$(dirname "$0")/../.."
. denoise/train/retrain_setup.sh
retrain_begin build-retrain/guide "fewray-odis-data" "$@"

if [ $tiny = 1 ]; then
    scenes=24 chunk=12 held=4 maps=100 held_maps=50 held_samples=8 width=192 minutes=0.7 spp=256 picture=240
else
    scenes=2000 chunk=100 held=50 maps=300 held_maps=80 held_samples=64 width=384 minutes=120 spp=4096 picture=700
fi
initials=1,1,1,2,4,8

# Data of CHUNK scenes a file, so that an interrupted run loses no more. $1: file, $2: seed; then options and scenes.
make_maps() {
    [ -e "$1" ] && return
    file=$1 seed=$2
    shift 2
    build/fewray-odis-data -o "$file.part" --seed "$seed" --initials $initials --width $width "$@"
    mv "$file.part" "$file"
}

all_maps() {
    make_maps "$out/held.bin" 1 --maps $held_maps --samples $held_samples "$out"/held/*.xml
    first=0
    set -- "$out"/scenes/*.xml
    while [ $# -gt 0 ]; do
        few=""
        count=0
        while [ $# -gt 0 ] && [ $count -lt $chunk ]; do
            few="$few $1"
            count=$((count + 1))
            shift
        done
        first=$((first + count))
        make_maps "$out/maps-$(printf %04d $first).bin" $first --maps $maps $few
    done
}

# 4 samples a pixel of a scene that the network never saw: without a guide, by the network in the repository, by the new one.
figure() {
    scene=examples/door-ajar.xml
    render="build/fewray render $scene --width $picture --denoise off --pilot off"
    $render --spp $spp --seed 99 -o "$out/reference.exr"
    $render --guide off -o "$out/plain.exr"
    $render -o "$out/shipped.exr"
    $render --guide-weights "$out/odis.bin" -o "$out/guided.exr"
    build/fewray composite "$out/plain.exr" "$out/guided.exr" "$out/reference.exr" -o "$out/guided.png" \
        --caption "4 samples a pixel, undenoised: path tracing, guided by the new network"
    {
        echo "mrse at 4 samples a pixel, undenoised, $scene at $picture pixels a row:"
        echo "path tracing                   $(mrse "$out/plain.exr" "$out/reference.exr")"
        echo "guided, network in repository  $(mrse "$out/shipped.exr" "$out/reference.exr")"
        echo "guided, new network            $(mrse "$out/guided.exr" "$out/reference.exr")"
    } >"$out/errors.txt"
    cat "$out/errors.txt"
}

train() {
    "$python" guide/train/train.py "$out"/maps-*.bin --validation "$out/held.bin" -o "$out/run" --minutes $minutes --resume \
        --threads "$(nproc)"
}

once scenes build/fewray-make-scenes --materials diffuse --seed 1 --count $scenes -o "$out/scenes"
once held-scenes build/fewray-make-scenes --materials diffuse --seed 2 --count $held -o "$out/held"
once maps all_maps
once training train
once export "$python" guide/train/export.py "$out/run/odis.pt" -o "$out/odis.bin" --reference "$out/odis_reference.bin" \
    --data "$out/held.bin"
once errors figure
echo "weights:  $out/odis.bin, for fewray render --guide-weights; $out/guided.png shows what they do"
echo "built in: cp $out/odis.bin guide/train/weights/; cp $out/odis_reference.bin tests/data/; then build and test"

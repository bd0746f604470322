#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The denoiser's network in one command from nothing: packages, PyTorch, build, scenes, renders, training, weights, an error
# figure.
#     sh denoise/train/retrain.sh [--tiny] [OUT]     OUT: build-retrain/denoise
# --tiny goes through all of it in three minutes beside the build, with the fast model; such a network is no good. An interrupted
# run goes on. README.md beside this file tells what each step does. Leaves OUT/kpn.bin, OUT/kpn_fast.bin (--tiny: this alone),
# OUT/errors.txt and OUT/denoised.png.
set -eu
cd "$(dirname "$0")/../.."
. denoise/train/retrain_setup.sh
retrain_begin build-retrain/denoise "fewray-kpn-data fewray-kpn-ops" "$@"

if [ $tiny = 1 ]; then
    scenes=10 size="--width 160 --height 112 --reference-spp 64" models=fast minutes=1 training="--crop 64 --batch 8" spp=256 picture=240
else
    scenes=300 size="--views 4" models="default fast" minutes=60 training="" spp=4096 picture=700
fi

views() {
    "$python" denoise/train/make_data.py "$out"/scenes/*.xml -o "$out/views" --guide --guide-reference --threads "$(nproc)" $size
}

train() {
    "$python" denoise/train/train.py "$out/views" -o "$out/$1.pt" --model "$1" --minutes $minutes --threads "$(nproc)" $training
}

file_of() {
    if [ "$1" = default ]; then echo kpn; else echo "kpn_$1"; fi
}

export_model() {
    "$python" denoise/train/export.py "$out/$1.pt" -o "$out/$(file_of "$1").bin" --test "$out/$(file_of "$1")_reference.bin"
}

# 4 samples a pixel of a scene that the network never saw: noisy, by the model in the repository, by the new one.
figure() {
    scene=examples/door-ajar.xml
    render="build/fewray render $scene --width $picture --denoise off --pilot off"
    $render --spp $spp --seed 99 -o "$out/reference.exr"
    $render -o "$out/noisy.exr"
    {
        echo "mrse at 4 samples a pixel, guided, $scene at $picture pixels a row:"
        echo "noisy                               $(mrse "$out/noisy.exr" "$out/reference.exr")"
    } >"$out/errors.txt"
    for model in $models; do
        build/fewray denoise "$out/noisy.exr" --model "$model" -o "$out/shipped-$model.exr"
        build/fewray denoise "$out/noisy.exr" --denoise-weights "$out/$(file_of "$model").bin" -o "$out/denoised-$model.exr"
        {
            echo "model $model, network in repository  $(mrse "$out/shipped-$model.exr" "$out/reference.exr")"
            echo "model $model, new network            $(mrse "$out/denoised-$model.exr" "$out/reference.exr")"
        } >>"$out/errors.txt"
    done
    build/fewray composite "$out/noisy.exr" "$out/denoised-$model.exr" "$out/reference.exr" -o "$out/denoised.png" \
        --caption "4 samples a pixel, before and after the new network ($model)"
    cat "$out/errors.txt"
}

export FEWRAY_KPN_OPS="$PWD/build/libfewray-kpn-ops.so"
once scenes build/fewray-make-scenes --seed 1 --count $scenes -o "$out/scenes"
once views views
for model in $models; do
    once "training-$model" train "$model"
    once "export-$model" export_model "$model"
done
once errors figure
echo "weights:  $out/kpn*.bin, for fewray render and denoise --denoise-weights; $out/denoised.png shows what they do"
echo "built in: copy them to denoise/train/weights/, $out/kpn*_reference.bin to tests/data/; then build and test"

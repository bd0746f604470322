#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# `fewray report` makes a page that works by mouse, touch and keys, with nothing from the network: tests/adopt/test_report.py
# tries it in headless Chromium.
set -eu
. tests/packages.sh
install_missing $BUILD_PACKAGES chromium chromium-driver python3-selenium
build=build-adopt/report
cmake -S . -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEWRAY_TESTS=OFF > /dev/null
cmake --build "$build" --target fewray > /dev/null

pictures=$build/pictures
rm -rf "$pictures"
mkdir "$pictures"
render() {
    name=$1
    shift
    "$build/fewray" render examples/door-ajar.xml --width 480 --height 300 -o "$pictures/$name.exr" --stats "$pictures/$name.json" "$@"
}
render reference --spp 512 --seed 9 --float
render guided --spp 4
render plain --spp 4 --guide off --denoise off
"$build/fewray" bench examples/door-ajar.xml --reference "$pictures/reference.exr" --spp 1,2,4 --seeds 2 -o "$pictures" > /dev/null
"$build/fewray" report "$pictures" --title "door-ajar, 4 samples a pixel"
/usr/bin/python3 tests/adopt/test_report.py "$pictures/report.html" "$build/screenshots"

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Mitsuba 3, where Python has it (PYTHON=FILE names another one than python3), is guided: examples/mitsuba renders a scene and
# its guided mean is the plain one.
set -eu
python=${PYTHON:-python3}
"$python" -c "import mitsuba, fewray" 2>/dev/null || { echo "skipped: no Mitsuba 3 with fewray in $python"; exit 0; }
folder=build-adopt/mitsuba
mkdir -p "$folder"
"$python" examples/mitsuba/render.py examples/cornell-box.xml -o "$folder/guided.exr" --spp 4 --width 64 --height 64
"$python" examples/mitsuba/measure.py --means 16 examples/cornell-box.xml | tee "$folder/means.txt"
# Of 72 blocks 0.2 are beyond three standard errors by chance; more than three at most once in 10,000 runs.
awk -F'|' '$6 ~ /of/ { split($6, n, " "); found = 1; if (n[1] > 3) exit 1 } END { exit !found }' "$folder/means.txt"

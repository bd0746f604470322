#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# With FEWRAY_RENDERER=OFF the library builds, passes its tests and serves a program where Embree, OpenCV, OpenImageIO,
# assimp, expat, jansson and MPI can't be found; with jansson the command is there, for EXRs.
set -eu
. tests/packages.sh
install_missing cmake ninja-build gcc g++ libc6-dev pkg-config binutils $DENOISE_PACKAGES libcmocka-dev libjansson-dev

folder=$PWD/build-adopt/denoise_only
rm -rf "$folder/build" "$folder/prefix" "$folder/pkgconfig" "$folder/consumer"
mkdir -p "$folder/pkgconfig"
for name in libdeflate libpng libpng16 zlib cmocka; do
    file=$(pkg-config --variable=pcfiledir $name)/$name.pc
    cp "$file" "$folder/pkgconfig/"
done
jansson=$(pkg-config --variable=pcfiledir jansson)/jansson.pc
picture=tests/metrics/cornell-box/reference.exr
PKG_CONFIG_LIBDIR=$folder/pkgconfig # nothing but these is known to pkg-config
export PKG_CONFIG_LIBDIR
without=""
for name in embree OpenCV OpenImageIO assimp EXPAT MPI; do
    without="$without -DCMAKE_DISABLE_FIND_PACKAGE_$name=ON"
done

cmake --no-warn-unused-cli -S . -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEWRAY_RENDERER=OFF $without -DCMAKE_INSTALL_PREFIX="$folder/prefix" >"$folder/log"
cmake --build "$folder/build" >>"$folder/log"
ctest --test-dir "$folder/build" --output-on-failure >>"$folder/log" || { tail -n 30 "$folder/log"; exit 1; }
cmake --install "$folder/build" >>"$folder/log"

library=$folder/prefix/lib/libfewray.so.1
if { ldd "$library"; ninja -C "$folder/build" -t deps; } | grep -E '/[^ ]*(embree|opencv|OpenImageIO|assimp|mpi\.h|expat|jansson)'; then
    echo "the library needs these, which it was to be built without" >&2
    exit 1
fi
test ! -e "$folder/prefix/include/fewray/guide.h"
for static in OFF ON; do
    cmake -S examples/consumer -B "$folder/consumer" -DCMAKE_PREFIX_PATH="$folder/prefix" -DSTATIC=$static -DDENOISE_ONLY=ON \
        >>"$folder/log"
    cmake --build "$folder/consumer" >>"$folder/log"
    "$folder/consumer/denoise"
done
"$folder/build/example-denoise_foreign" "$picture" "$folder/clean.exr"
test -s "$folder/clean.exr"

cp "$jansson" "$folder/pkgconfig/"
cmake --no-warn-unused-cli "$folder/build" >>"$folder/log"
cmake --build "$folder/build" --target fewray >>"$folder/log"
"$folder/build/fewray" --help
"$folder/build/fewray" denoise "$picture" -o "$folder/clean.exr" --stats "$folder/stats.json"
"$folder/build/fewray" info "$folder/clean.exr" | head -n 1
if "$folder/build/fewray" info examples/cornell-box.xml || "$folder/build/fewray" render examples/cornell-box.xml; then
    echo "the command took a scene without a renderer" >&2
    exit 1
fi

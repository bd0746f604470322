#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# An installed libfewray, shared and static, serves programs outside the tree, by CMake and by pkg-config, also after
# the installation was moved; it exports its own names alone, with a version.
set -eu
. tests/packages.sh
install_missing $BUILD_PACKAGES binutils

folder=$PWD/build-adopt/install
moved=$folder/moved
programs=$folder/programs
rm -rf "$folder/prefix" "$moved" "$programs"
mkdir -p "$programs"
cmake -S . -B "$folder/build" -G Ninja -DCMAKE_BUILD_TYPE=Release -DFEWRAY_TESTS=OFF -DCMAKE_INSTALL_PREFIX="$folder/prefix" >"$folder/log"
cmake --build "$folder/build" >>"$folder/log"
cmake --install "$folder/build" >>"$folder/log"

# build_programs PREFIX NAME: four ways, programs/NAME-WAY-denoise and -render
build_programs() {
    for kind in shared static; do
        static=OFF
        [ $kind = shared ] || static=ON
        cmake -S examples/consumer -B "$programs/$2-cmake-$kind" -DCMAKE_PREFIX_PATH="$1" -DSTATIC=$static \
            -DCMAKE_BUILD_TYPE=Release >>"$folder/log"
        cmake --build "$programs/$2-cmake-$kind" >>"$folder/log"

        export PKG_CONFIG_PATH="$1/lib/pkgconfig"
        flags="$(pkg-config --cflags --libs fewray) -Wl,-rpath,$1/lib"
        [ $kind = shared ] || flags="$(pkg-config --cflags --static --libs fewray | sed s/-lfewray/-l:libfewray.a/)"
        mkdir "$programs/$2-pkgconfig-$kind"
        cc -Wall -Wextra -Werror examples/consumer/denoise.c $flags -lm -o "$programs/$2-pkgconfig-$kind/denoise"
        c++ -Wall -Wextra -Werror examples/consumer/render.cpp $flags -o "$programs/$2-pkgconfig-$kind/render"
    done
}

run_programs() {
    for program in "$programs/$1"-*; do
        echo "$(basename "$program"): $("$program/denoise")"
        (cd / && "$program/render" "$scene" "$program/out.exr")
        test -s "$program/out.exr"
        ! ldd "$program/render" | grep -E 'embree|opencv|OpenImageIO|assimp|libmpi' || exit 1
    done
}

scene=$PWD/examples/cornell-box.xml
build_programs "$folder/prefix" first
run_programs first
mv "$folder/prefix" "$moved"
build_programs "$moved" moved
FEWRAY_MODULE_PATH=$(pkg-config --variable=moduledir fewray) # for the static ones
export FEWRAY_MODULE_PATH
run_programs moved
unset FEWRAY_MODULE_PATH
for way in cmake pkgconfig; do
    "$programs/moved-$way-shared/render" "$scene" "$programs/out.exr"
    ! ldd "$programs/moved-$way-static/denoise" | grep libfewray || exit 1
done
mkdir "$programs/links" # where a link to the library has no modules beside it
ln -s "$moved/lib/libfewray.so.1" "$programs/links/"
LD_PRELOAD=$programs/links/libfewray.so.1 "$programs/moved-cmake-shared/render" "$scene" "$programs/out.exr"
"$moved/bin/fewray" render "$scene" -o "$programs/out.exr" --width 16
"$moved/bin/fewray" --version

library=$moved/lib/libfewray.so.1
nm -D --with-symbol-versions --defined-only "$library" | awk '$2 != "A" {print $3}' | sort >"$folder/exported"
grep -hv '#define' "$moved"/include/fewray/*.h | tr '\n' ' ' | grep -oE 'FEWRAY_API [^(;]*\(' |
    sed -E 's/.*[ *](fewray_[a-z0-9_]+)\(/\1@@FEWRAY_1/' | sort >"$folder/declared"
diff "$folder/declared" "$folder/exported"
readelf -d "$library" | grep -q 'SONAME.*libfewray.so.1]'
! readelf -d "$library" | grep NEEDED | grep -E 'embree|opencv|OpenImageIO|assimp|libmpi|libstdc' || exit 1
if nm --extern-only --defined-only --format=posix "$moved/lib/libfewray.a" | awk 'NF > 1' | grep -v '^fewray_'; then
    echo "libfewray.a defines these names without prefix" >&2
    exit 1
fi
echo "$(wc -l <"$folder/exported") functions exported, all of them FEWRAY_1"

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The Debian package holds all that `cmake --install` puts in place, names the packages it depends on, and its command
# and library work from wherever it is unpacked.
set -eu
. tests/packages.sh
install_missing $BUILD_PACKAGES dpkg-dev file

folder=$PWD/build-adopt/package
rm -rf "$folder/unpacked" "$folder"/*.deb
mkdir -p "$folder"
cmake --preset package -B "$folder/build" >"$folder/log"
cmake --build "$folder/build" >>"$folder/log"
(cd "$folder" && cpack --config build/CPackConfig.cmake >>"$folder/log")
package=$(echo "$folder"/fewray_*.deb)
test -f "$package"
dpkg-deb --info "$package" >"$folder/info"
dpkg-deb --contents "$package" >"$folder/contents"

for field in "Package: fewray" "Section: graphics" "Architecture: $(dpkg --print-architecture)" \
    "Depends:.*libc6" "Depends:.*libembree" "Depends:.*libopencv-core" "Depends:.*libopenimageio" "Depends:.*libgomp1"; do
    grep -q "$field" "$folder/info" || { echo "the package lacks the field '$field'" >&2; exit 1; }
done
multiarch=$(dpkg-architecture -qDEB_HOST_MULTIARCH)
for file in usr/bin/fewray usr/include/fewray/fewray.h usr/include/fewray/denoise.h "usr/lib/$multiarch/libfewray.so" \
    "usr/lib/$multiarch/libfewray.so.1" "usr/lib/$multiarch/libfewray.a" "usr/lib/$multiarch/fewray/fewray_embree.so" \
    "usr/lib/$multiarch/pkgconfig/fewray.pc" "usr/lib/$multiarch/cmake/fewray/fewrayConfig.cmake" usr/share/doc/fewray/copyright; do
    grep -q " \./$file\( ->.*\)\?\$" "$folder/contents" || { echo "the package lacks $file" >&2; exit 1; }
done
if awk '$2 != "root/root"' "$folder/contents" | grep .; then
    echo "files of the package aren't root's" >&2
    exit 1
fi

dpkg-deb -I "$package" shlibs | grep -q '^libfewray 1 fewray'

dpkg-deb -x "$package" "$folder/unpacked"
fewray=$folder/unpacked/usr/bin/fewray
$fewray render examples/cornell-box.xml -o "$folder/noisy.exr" --width 32 --denoise off
$fewray denoise "$folder/noisy.exr" -o "$folder/clean.exr"
PKG_CONFIG_PATH=$folder/unpacked/usr/lib/$multiarch/pkgconfig
export PKG_CONFIG_PATH
cc examples/consumer/denoise.c $(pkg-config --cflags --libs fewray) -lm -o "$folder/program"
LD_LIBRARY_PATH=$folder/unpacked/usr/lib/$multiarch "$folder/program"
sed -n 's/^ \(Installed-Size\|Depends\)/\1/p' "$folder/info"

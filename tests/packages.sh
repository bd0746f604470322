#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Debian packages that a build needs; sourced by tests/run.sh, tests/fuzz/run.sh and
# examples/run.sh.
# install_missing PACKAGE... installs those that aren't there, and asks for root's rights only then.

DENOISE_PACKAGES="libopenexr-dev libdeflate-dev libpng-dev zlib1g-dev" # all that FEWRAY_RENDERER=OFF needs
BUILD_PACKAGES="cmake ninja-build gcc g++ libc6-dev pkg-config $DENOISE_PACKAGES libembree-dev libopenimageio-dev
libopencv-dev libexpat1-dev libjansson-dev libassimp-dev"
case $(cat /etc/debian_version 2>/dev/null) in # the Clang that is the release's own
12*) CLANG=14 ;;
*) CLANG=19 ;;
esac
CLANG_PACKAGES="clang-$CLANG libclang-rt-$CLANG-dev libomp-$CLANG-dev llvm-$CLANG" # llvm: the symbolizer of suppressions
BY_CLANG="-DCMAKE_C_COMPILER=clang-$CLANG -DCMAKE_CXX_COMPILER=clang++-$CLANG" # for presets, which say clang-14
TEST_PACKAGES="libcmocka-dev openmpi-bin libopenmpi-dev"

install_missing() {
    missing=""
    for package in "$@"; do
        dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q "install ok installed" ||
            missing="$missing $package"
    done
    [ -z "$missing" ] && return
    echo "installing:$missing"
    as_root=""
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || { echo "please install, as root: apt-get install -y$missing" >&2; exit 1; }
        as_root="sudo"
    fi
    $as_root apt-get update -q
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -q --no-install-recommends $missing
}

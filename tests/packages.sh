#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Debian packages that a build needs; sourced by tests/run.sh, tests/fuzz/run.sh and
# examples/run.sh.
# install_missing PACKAGE... installs those that aren't there, and asks for root's rights only then.

DENOISE_PACKAGES="libopenexr-dev libdeflate-dev libpng-dev zlib1g-dev" # all that FEWRAY_RENDERER=OFF needs
BUILD_PACKAGES="cmake ninja-build gcc g++ libc6-dev pkg-config $DENOISE_PACKAGES libembree-dev libopenimageio-dev
libopencv-dev libexpat1-dev libjansson-dev libassimp-dev"
CLANG_PACKAGES="clang-14 libclang-rt-14-dev libomp-14-dev llvm-14" # which has the symbolizer that suppressions go by
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

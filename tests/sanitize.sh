#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# The whole suite under sanitizers, of the presets asan and tsan or those that are named:
# sh tests/sanitize.sh [PRESET...]. Any report fails the test that made it.
#
# asan: addresses, leaks, undefined behaviour and casts of floats that don't fit the integer.
#   Not division by zero: of floats it is an infinity, which boxes and rays are meant to have.
#   Options: allocator_may_return_null, as tests ask for what no memory holds;
#   intercept_tls_get_addr=0, as gcc 12's search for leaks crashes in glibc's own list of threads;
#   fast_unwind_on_malloc=0, as leaks.supp knows other libraries' leaks by their callers.
# tsan: by Clang. ThreadSanitizer can't see the barriers of gcc's OpenMP library, and takes all that
#   passes them for races; Clang's tells of them by its tool Archer, so that nothing of OpenMP is
#   suppressed. Its warnings aren't errors: those of gcc are.
#   PMIX_MCA_gds=hash, as memory that Open MPI 5 shares at a fixed address lies where TSan's own is.
set -eu
cd "$(dirname "$0")/.."
. tests/packages.sh
install_missing $BUILD_PACKAGES $TEST_PACKAGES $CLANG_PACKAGES

[ $# -gt 0 ] || set -- asan tsan
for preset in "$@"; do
    compiler=""
    [ "$preset" = tsan ] && compiler=$BY_CLANG
    cmake --preset "$preset" $compiler
    cmake --build --preset "$preset"
    ctest --preset "$preset"
done

#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Each public header compiles by itself, as C and as C++, without a warning.
set -eu
. tests/packages.sh
install_missing gcc g++ libc6-dev
folders=$(ls -d */include | sed 's/^/-I/')
for header in */include/fewray/*.h; do
    for compiler in "gcc -x c -std=c17" "gcc -x c -std=c99" "g++ -x c++ -std=c++11" "g++ -x c++ -std=c++20"; do
        $compiler -Wall -Wextra -Wshadow -Wpedantic -Werror $folders -fsyntax-only -include "$header" /dev/null
    done
    echo "$header: C99, C17, C++11, C++20"
done

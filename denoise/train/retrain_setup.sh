# SPDX-License-Identifier: Apache-2.0
# What both retrain.sh begin with; sourced from the repository's root. Reads [--tiny] [OUT], installs Debian's packages, makes a
# Python environment with PyTorch and builds. Sets tiny (0 or 1), out, python; the build is in build/.
. tests/packages.sh

fail() {
    echo "retrain.sh: $*" >&2
    exit "${code:-1}"
}

# retrain_begin DEFAULT_OUT TARGETS [ARGUMENT...]
retrain_begin() {
    out=$1
    targets=$2
    shift 2
    tiny=0
    for argument in "$@"; do
        case $argument in
        --tiny) tiny=1 ;;
        -*) code=2 fail "$argument isn't an option: [--tiny] [OUT]" ;;
        *) out=$argument ;;
        esac
    done
    case $out in *[[:space:]]*) fail "$out: no spaces in the folder's name, please" ;; esac
    mkdir -p "$out"
    [ "$(cat "$out/tiny" 2>/dev/null || echo $tiny)" = $tiny ] ||
        fail "$out holds the run of another size (--tiny): take another folder"
    echo $tiny >"$out/tiny"
    install_missing $BUILD_PACKAGES python3 python3-venv
    cmake -S . -B build -G Ninja -DCMAKE_BUILD_TYPE=Release >"$out/build.log" 2>&1 &&
        cmake --build build --target fewray fewray-make-scenes $targets >>"$out/build.log" 2>&1 ||
        fail "the build failed: $out/build.log"
    make_environment
    step=0
}

# build-retrain/venv with PyTorch, of the version that the weights in the repository were trained with: the CPU wheel of PyTorch's
# own index, or where that can't be reached the one of PyPI, which brings CUDA along.
make_environment() {
    venv=${RETRAIN_VENV:-build-retrain/venv} # another one that is there may be shared
    python=$venv/bin/python3
    if ! "$python" -c "import torch, numpy" 2>/dev/null; then
        echo "== PyTorch into $venv"
        python3 -m venv "$venv"
        "$venv/bin/pip" install -q --no-deps --retries 1 --index-url https://download.pytorch.org/whl/cpu torch==2.13.0 \
            >/dev/null 2>&1 || echo "no CPU wheel of PyTorch: trying PyPI"
        "$venv/bin/pip" install -q torch==2.13.0 numpy || fail "PyTorch couldn't be installed"
    fi
    "$python" -c "import torch; print('PyTorch', torch.__version__)"
}

# once NAME COMMAND...: a step that is done isn't done again; its output goes to the terminal and to OUT/NAME.log.
once() {
    name=$1
    shift
    step=$((step + 1))
    if [ -e "$out/$name.done" ]; then
        echo "== $step. $name: done before"
        return
    fi
    echo "== $step. $name"
    { "$@" 2>&1 && touch "$out/$name.done"; } | tee "$out/$name.log"
    [ -e "$out/$name.done" ] || fail "$name failed: $out/$name.log; the same command goes on from there"
}

# mrse TEST.exr REFERENCE.exr
mrse() {
    build/fewray compare "$1" "$2" | sed -n 's/^mrse: //p'
}

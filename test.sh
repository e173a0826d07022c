#!/usr/bin/env bash
# Everything that can be checked on this machine: the shape of the text, warnings, every test on
# the CPU and on a GPU where there is one, kernels without local memory, and the program as a user
# runs it. Goes on after a failure; ends with what failed and 1, or 0. Logs under build/.
set -u
cd "$(dirname "$0")"
. .ci/setup.sh

mkdir -p build
failures=()
# Runs a check; its output goes to build/NAME.log and is shown where it fails.
check() {
    local name=$1 log start=$SECONDS
    shift
    log=build/${name// /-}.log
    if "$@" >"$log" 2>&1; then
        printf '  ok      %-40s %4d s\n' "$name" $((SECONDS - start))
        return 0
    fi
    printf '  FAILED  %-40s %4d s   %s\n' "$name" $((SECONDS - start)) "$log"
    tail -n 40 "$log" | sed 's/^/          | /'
    failures+=("$name")
    return 1
}

install "${build_packages[@]}" libgtest-dev

settings=(-DCMAKE_BUILD_TYPE=Release -DKNEAD_WERROR=ON)
nvcc=$(command -v nvcc || ls /usr/local/cuda/bin/nvcc 2>/dev/null)
if [ -z "$nvcc" ]; then
    say "No CUDA compiler here: the CPU side is built and tested, CUDA is left out."
elif ! gpu_present; then
    say "A CUDA compiler and no GPU: CUDA is compiled for sm_90 and its kernels are examined."
    settings+=(-DCMAKE_CUDA_ARCHITECTURES=90)
else
    say "A GPU: $(nvidia-smi -L | head -n 1). Every test that can use it does."
fi

say "Checking"
check "shape of the text" tests/shape_test.sh
check "includes go downwards" tests/includes_test.sh
check "pages name what is there" tests/docs_test.sh
check "configure" cmake -S . -B build/test -G Ninja "${settings[@]}" || exit 1
check "build without a warning" cmake --build build/test || exit 1
cuda=no
grep -q 'knead: CUDA' build/configure.log && cuda=yes
[ $cuda = yes ] && check "kernels without local memory" tests/kernels_test.sh build/test
check "headers alone" tests/headers_alone.sh
check "tests" timeout 1200 build/test/knead_tests --gtest_brief=1
check "the program" tests/cli/program_test.sh build/test/knead

grep -h '^\[  PASSED  \]\|^\[  SKIPPED \]' build/tests.log | head -n 2
if [ ${#failures[@]} -gt 0 ]; then
    say "FAILED after $SECONDS s: ${failures[*]}"
    exit 1
fi
say "All is well, after $SECONDS s"

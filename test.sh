#!/usr/bin/env bash
# Everything that can be checked on this machine: a build without a warning, then every test of
# CTest, on the CPU and on a GPU where there is one (ctest --test-dir build/test -N names them).
# Shows what fails, says what is left out, and ends with one line and 1 or 0. Logs under build/.
set -u
cd "$(dirname "$0")"
. .ci/setup.sh

mkdir -p build
# Does a step of the build; its output goes to build/NAME.log and is shown where it fails.
step() {
    local name=$1 log=build/$1.log start=$SECONDS
    shift
    if "$@" >"$log" 2>&1; then
        printf '  ok      %-24s %4d s\n' "$name" $((SECONDS - start))
        return
    fi
    printf '  FAILED  %-24s %4d s   %s\n' "$name" $((SECONDS - start)) "$log"
    grep -E 'rror|FAILED' "$log" | head -n 20 | sed 's/^/          | /'
    tail -n 20 "$log" | sed 's/^/          | /'
    say "FAILED after $SECONDS s: $name"
    exit 1
}

install "${build_packages[@]}" libgtest-dev doxygen xvfb libopenal1

settings=(-DCMAKE_BUILD_TYPE=Release -DKNEAD_WERROR=ON -DKNEAD_UNITED=ON)
nvcc=$(command -v nvcc || ls /usr/local/cuda/bin/nvcc 2>/dev/null)
if [ -z "$nvcc" ]; then
    say "No CUDA compiler here: the CPU side is built and tested, CUDA is left out."
elif ! gpu_present; then
    say "A CUDA compiler and no GPU: CUDA is compiled for sm_90 and its kernels are examined."
    settings+=(-DCMAKE_CUDA_ARCHITECTURES=90)
else
    say "A GPU: $(nvidia-smi -L | head -n 1). Every test that can use it does."
fi
step configure cmake -S . -B build/test -G Ninja "${settings[@]}"
grep -o 'knead: .*' build/configure.log
step build cmake --build build/test

say "Testing"
fine='^ +Start |^ *[0-9]+/[0-9]+ .*( Passed |\*\*\*Skip)|\(Skipped\)$|did not run:|^Internal|^$'
# Some tests wait more than they compute, so three run at a time on two cores; each has one thread,
# but where it asks for more, for threads that wait for each other take longer than one.
export OMP_NUM_THREADS=1
ctest --test-dir build/test --parallel 3 --output-on-failure --no-tests=error 2>&1 |
    tee build/tests.log | grep -vE "$fine"
failed=${PIPESTATUS[0]}
passed=$(grep -cE ' Passed +[0-9.]+ sec$' build/tests.log)
skipped=$(grep -cE '\*\*\*Skipped +[0-9.]+ sec$' build/tests.log)
counts="$passed tests passed, $skipped skipped"
gpu_present || counts+=" (most of them for want of a GPU; build/tests.log names them)"
if [ "$failed" -ne 0 ]; then
    say "FAILED after $SECONDS s: $counts; see build/tests.log"
    exit 1
fi
say "All is well, after $SECONDS s: $counts"

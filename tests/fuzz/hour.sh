#!/usr/bin/env bash
# An hour, or as long as asked, of fuzzing under the address and undefined-behaviour sanitizers,
# shared by all formats: with libFuzzer where there is clang, and by the driver's own changes. What
# is found is left in build/fuzz/found.
# usage: tests/fuzz/hour.sh [MINUTES] [SEED]
set -eu
minutes=${1:-60} seed=${2:-$RANDOM}
cd "$(dirname "$0")/../.."
export OMP_NUM_THREADS=1
export ASAN_OPTIONS=max_allocation_size_mb=1024
build=build/fuzz
compiler=()
if command -v clang++ >/dev/null; then compiler=(-DCMAKE_CXX_COMPILER=clang++); fi
cmake -S . -B $build -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DKNEAD_CUDA=OFF -DKNEAD_FUZZ=ON \
    "${compiler[@]}" >/dev/null
cmake --build $build >$build/build.log
mkdir -p $build/found
formats=$($build/knead_fuzz --list)
set -- $formats
seconds=$((60 * minutes / $#))
echo "$# formats, $seconds s each, seed $seed"
failed=0
for format; do
    half=$seconds
    if [ -x $build/fuzz-$format ]; then
        half=$((seconds / 2))
        $build/knead_fuzz --seeds $build/corpus "$format"
        $build/fuzz-$format -max_total_time=$half -timeout=20 -rss_limit_mb=3000 -seed="$seed" \
            -print_final_stats=1 -artifact_prefix=$build/found/$format- \
            $build/corpus/"$format" tests/fuzz/corpus/"$format" \
            >$build/"$format".log 2>&1 || failed=$((failed + 1))
        grep -E 'number_of_executed_units|SUMMARY' $build/"$format".log | sed "s/^/$format /"
    fi
    $build/knead_fuzz --seconds $half --seed "$seed" --keep $build/found/"$format" "$format" ||
        failed=$((failed + 1))
done
echo "$failed formats with a fault"
exit $((failed > 0))

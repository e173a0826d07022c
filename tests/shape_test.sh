#!/usr/bin/env bash
# Holds the source to its shape: the bounds of CONTRIBUTING.md, "Format", by reading the text.
# Prints every place that breaks one; fails if there is any.
set -u
cd "$(dirname "$0")/.."
export LC_ALL=C.UTF-8

shopt -s nullglob lastpipe globstar
shipped=(cuda/**/*.{h,cuh,cu} host/**/*.{h,cuh,cpp,cu} render/*.{h,cpp} render/view/*.{h,cpp}
    xr/*.h xr/*.cpp)
source=("${shipped[@]}" tests/**/*.h tests/**/*.cpp profiling/**/*.{h,cuh,cpp,cu} examples/*.cpp)
text=("${source[@]}" tests/**/*.sh tests/**/*.py profiling/**/*.py
    profiling/*/*.sh demo.sh test.sh .ci/* CMakeLists.txt
    {cuda,host,render,xr,tests,profiling,examples}/**/CMakeLists.txt cmake/*.cmake
    CMakePresets.json)
words=("${text[@]}" {README,CHANGELOG,CONTRIBUTING,SECURITY}.md CITATION.cff docs/{,*/}*.md
    profiling/*.md scenes/*.json)
[ ${#shipped[@]} -gt 0 ] || { echo "no source found"; exit 1; }

. tests/none.sh

grep -nE '^.{101,}' "${text[@]}" | cut -c1-90 | none "lines of more than 100 columns"
grep -nP '\t| +$|\r' "${text[@]}" | none "tabs or blanks at the end of a line"
grep -nE '__CUDA_ARCH__|__CUDACC__' "${source[@]}" | grep -v '^cuda/math/hd\.h:' |
    none "__CUDA_ARCH__ and __CUDACC__ belong in cuda/math/hd.h"
grep -nE '#define +[A-Za-z_0-9]+(\(| +[^ ])' "${shipped[@]}" |
    grep -vE '^(cuda/math/hd|host/solver/cpu/namespace)\.h:' |
    none "macros with a value other than HD, UNROLL and KNEAD_CPU_LEVEL"
grep -n '<<<' "${source[@]}" | grep -v '^cuda/device/launch\.cuh:' |
    none "kernels that start elsewhere than in cuda/device/launch.cuh have no range in a profiler"
grep -n 'cudaDeviceSynchronize *(' "${shipped[@]}" |
    none "waits for a whole device, which end whatever another thread is capturing"
grep -nE 'std::(printf|puts|putchar|cout)|[,(] *stdout\)|fmt::print\((\"|$)' "${shipped[@]}" |
    grep -vE '^host/base/print\.cpp:' |
    none "data that is lost unsaid where the standard output is full: print() of host/base/print.h"
grep -nE '#pragma omp|<omp\.h>' "${source[@]}" |
    none "loops whose threads spin: parallel_for() of host/base/parallel.h"
# "debug_utils" is a name of OpenXR's, "sa_handler" one of POSIX's, "set_handler" one of ALSA's.
silent='(managers?|helpers?|handlers?|utils?|impl|misc)(?![a-z]|_t\b)'
grep -niP "(?<![a-z])(?<!debug)(?<!debug_)(?<!sa_)(?<!set_)$silent" "${source[@]}" |
    grep -v '#include <backends/imgui_impl_' |
    none "names that say nothing: manager, helper, handler, util, impl, misc"
grep -nwE 'TODO|FIXME|XXX|NOLINT.*' "${source[@]}" | none "things left undone"
grep -nE '/(home|root|work)/' "${words[@]}" | grep -v '^tests/shape_test\.sh:' |
    none "paths of somebody's machine"

# A body is what stands between a brace alone on its line, after a function's head, and the one
# that closes it.
awk '
    FNR == 1 { depth = 0 }
    /^ *\{$/ && !depth && last ~ /([)}]|const|override|noexcept)$/ {
        depth = index($0, "{"); from = FNR; head = before; next
    }
    depth && index($0, "}") == depth && /^ *\}[;,)]*$/ {
        bound = head ~ /__global__/ ? 40 : 60
        if (FNR - from - 1 > bound) print FILENAME ":" from ": " FNR - from - 1 " lines"
        depth = 0
    }
    { last = $0; before = /^ / ? before $0 : $0 }' "${shipped[@]}" |
    none "functions of more than 60 lines, kernels of more than 40"

# Commas outside brackets, from a kernel's name to the end of its parameters.
awk '
    FNR == 1 { text = "" }
    /__global__/ { text = " "; at = FNR }
    text != "" {
        text = text $0
        if (!/[{;]$/) next
        gsub(/__launch_bounds__\([^)]*\)/, "", text)
        while (gsub(/<[^<>]*>/, "", text)) {}
        sub(/^[^(]*\(/, "", text)
        if (gsub(/,/, "", text) + 1 > 8) print FILENAME ":" at
        text = ""
    }' cuda/**/*.cu host/**/*.cu /dev/null | none "kernels of more than 8 parameters"

# Numbers in brackets in the stages' comments are equations; names with a year are papers.
model=docs/method/model.md
grep -ohE '//.*' cuda/**/*.{h,cuh,cu} | grep -oE '\([0-9]{1,2}\)' |
    sort -u | while read -r number; do
    grep -qF "**$number**" $model || echo "$number"
done | none "equations that the stages cite and $model does not have"
grep -ohE '//.*' cuda/**/*.{h,cuh,cu} | grep -oE '\[[A-Z][^]]* (19|20)[0-9]{2}' | tr -d '[' |
    grep -oE '[A-Z][a-z]+ (19|20)[0-9]{2}' | sort -u | while read -r paper; do
    grep -qF "[$paper]" $model || echo "$paper"
done | none "papers that the stages cite and $model does not list"

if [ $failed -gt 0 ]; then
    echo "$failed rules broken"
    exit 1
fi
echo "${#source[@]} files keep to the shape"

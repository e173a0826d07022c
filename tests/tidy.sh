#!/usr/bin/env bash
# Checks .cpp files by clang-tidy 14 and .clang-tidy. Not part of test.sh: a file takes 2 to 40 s.
# Prints every finding once; fails if there is any.
# usage: tests/tidy.sh [-p FOLDER] [FILE...]
#        -p FOLDER  a configured build folder, for its compile_commands.json (build/test)
#        FILE       default: every .cpp file outside tests/ but no_gpu_*.cpp
# A build folder of test.sh lists files that are compiled together; clang-tidy then derives a file's
# command from a neighbour's. One configured with -DKNEAD_UNITED=OFF has each file's own.
set -u
cd "$(dirname "$0")/.."
shopt -s nullglob globstar

usage() { grep '^# usage:' -A 2 "$0" | sed 's/^# \{0,1\}//'; exit "$1"; }
folder=build/test
while getopts :p:h option; do
    case $option in
        p) folder=$OPTARG ;;
        h) usage 0 ;;
        *) usage 2 >&2 ;;
    esac
done
shift $((OPTIND - 1))

for program in clang-tidy-14 clang-tidy ""; do
    [[ -n $program && $("$program" --version 2>/dev/null) == *"version 14."* ]] && break
done
if [ -z "$program" ]; then
    echo "no clang-tidy 14 here (Debian: apt-get install clang-tidy-14): nothing checked"
    exit 77
fi
if [ ! -e "$folder/compile_commands.json" ]; then
    echo "no compile_commands.json in $folder: configure a build there, or name another by -p" >&2
    exit 2
fi

files=("$@")
[ $# -gt 0 ] || for file in {host,render,xr,profiling,examples}/**/*.cpp; do
    # These only refuse: they take what they do not keep, as the definitions for CUDA declare it.
    [[ $file == */no_gpu_* ]] || files+=("$file")
done
for file in "${files[@]}"; do
    [ -e "$file" ] || { echo "no such file: $file" >&2; exit 2; }
done

logs=$(mktemp -d)
trap 'rm -rf "$logs"' EXIT
# The commands are GCC's: clang does not know all of its warnings, and -Werror would make that and
# clang's own warnings errors. Nor does clang 14 know -fwhole-program, or levels of x86-64 as
# features of a processor.
sed -E 's/ -(Werror|fwhole-program|DKNEAD_CPU_LEVELS)(=[^ ]*)?//g' "$folder/compile_commands.json" \
    >"$logs/compile_commands.json"
mkdir "$logs/out"
# One log a file, so that the outputs of files that are checked at a time do not mix.
printf '%s\0' "${files[@]}" | xargs -0 -P "$(nproc)" -I '{}' bash -c '
    log=$2/out/${3//\//+}
    "$1" --quiet -p "$2" "$3" >"$log" 2>"$log.error" ||
        echo "$3: error: clang-tidy ends with exit code $?" >>"$log"
    ' tidy "$program" "$logs" '{}'
# A finding in a header appears once for each file that includes it.
findings=$(grep -hE '^[^ ]+: (warning|error): ' "$logs"/out/* |
    sed "s|^$PWD/||" | sort -u)
if [ -n "$findings" ]; then
    printf '%s\n' "$findings"
    echo "$(wc -l <<<"$findings") findings in ${#files[@]} files"
    exit 1
fi
echo "${#files[@]} files without a finding"

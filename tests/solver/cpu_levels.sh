#!/usr/bin/env bash
# The code of a CPU level is used by that level alone: its object files define nothing weak, of
# which the linker could take the level's copy for the whole program, and no name that another
# object file of the library defines, too. Prints every symbol that breaks this.
# usage: tests/solver/cpu_levels.sh LIBRARY OBJECT...
set -u
library=${1:?usage: tests/solver/cpu_levels.sh LIBRARY OBJECT...}
shift
shopt -s lastpipe
. "$(dirname "$0")/../none.sh"

# "KIND NAME" of each symbol that the files define for others. Without those that have no code: the
# pointer to the function by which exceptions pass (DW.ref), and constants without a value (C).
defined() {
    nm -g --defined-only "$@" | awk 'NF == 3 && $2 != "C" && !/ DW\.ref\./ { print $2, $3 }'
}

[ $# -gt 0 ] || { echo "no object files of levels"; exit 1; }
count=$(defined "$@" | wc -l)
defined "$@" | grep '^[WVuvwi] ' | sort -u | c++filt | none "weak symbols in a level"
comm -12 <(defined "$@" | cut -d' ' -f2 | sort -u) \
    <(defined "$library" | cut -d' ' -f2 | sort | uniq -d) | c++filt |
    none "symbols of a level that another object file defines, too"
echo "$count symbols in $# object files of levels"
[ "$count" -gt 0 ] && [ $failed -eq 0 ]

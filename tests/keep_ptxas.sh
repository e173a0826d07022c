#!/bin/sh
# Runs the CUDA compiler as given; what it says (with -Xptxas=-v: registers, stack and spills of
# every kernel) is kept beside the object for tests/kernels_test.sh. A clean compile is silent.
set -u
object=
previous=
for argument in "$@"; do
    [ "$previous" = -o ] && object=$argument
    previous=$argument
done
[ -n "$object" ] || exec "$@"
"$@" 2>"$object.ptxas"
code=$?
grep -vE "^ptxas info|^ +[0-9]+ bytes stack frame|^ *$" "$object.ptxas" >&2
exit $code

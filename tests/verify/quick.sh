#!/usr/bin/env bash
# All of knead verify, small: no check fails but those of tests/verify/known.txt, which says why.
# usage: tests/verify/quick.sh PROGRAM [DEVICE]
set -u
here=$(dirname "$(realpath "$0")")
program=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT

"$program" verify --quick --device "${2:-cpu}" --threads 1 --out "$folder/out" >"$folder/said" 2>&1
code=$?
tail -n 1 "$folder/said"
if [ $code -gt 1 ] || [ ! -s "$folder/out/verify.csv" ]; then
    tail -n 20 "$folder/said"
    exit 1
fi

failed=0
while read -r name; do
    grep -qxF -- "$name" <(grep -v '^#' "$here/known.txt") && continue
    grep -F -A 2 -- "$name" "$folder/said"
    failed=$((failed + 1))
done < <(sed -n '/,FAILED,[0-9.]*$/s/^[a-z]*,"\([^"]*\)".*/\1/p' "$folder/out/verify.csv")
while read -r name; do
    grep -F -- ",\"$name\"," "$folder/out/verify.csv" | grep -q ',FAILED,' ||
        echo "passes now, take it from known.txt: $name"
done < <(grep -v '^#' "$here/known.txt")
echo "$failed checks failed that are not known to"
[ $failed -eq 0 ]

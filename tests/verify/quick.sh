#!/usr/bin/env bash
# All of knead verify, small: no check fails but those of profiling/known.json, which says why.
# usage: tests/verify/quick.sh PROGRAM [DEVICE]
set -u
data=$(realpath "$(dirname "$0")/../../profiling")
program=$(realpath "$1")
folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT

"$program" verify --quick --device "${2:-cpu}" --threads 1 --data "$data" --out "$folder/out" \
    >"$folder/said" 2>&1
code=$?
tail -n 1 "$folder/said"
if [ $code -gt 1 ] || [ ! -s "$folder/out/verify.csv" ]; then
    tail -n 20 "$folder/said"
    exit 1
fi

# Names of the checks whose lines end in this.
named() { sed -n 's/^[a-z]*,"\([^"]*\)".*'"$1"'$/\1/p' "$folder/out/verify.csv"; }
named ',passes now' | sed 's/^/passes now, take it from known.json: /'
failed=$(named ',FAILED,[0-9.]*,not known')
[ -z "$failed" ] || grep -F -A 2 -- "$failed" "$folder/said"
echo "$(echo -n "$failed" | grep -c '') checks failed that are not known to"
[ -z "$failed" ]

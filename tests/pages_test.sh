#!/usr/bin/env bash
# The pages that Doxygen made: no link and no picture leads to a file that is not there.
# usage: tests/pages_test.sh FOLDER
set -u
cd "${1:?usage: tests/pages_test.sh FOLDER}" || exit 1
[ -e index.html ] || { echo "no pages in $1"; exit 1; }
grep -oP '(?<=href=")[^"#:]+(?=[#"])|(?<=src=")[^":]+(?=")' ./*.html | sort -u >links
wrong=0
while IFS=: read -r page link; do
    [ -e "${link%%\?*}" ] && continue
    echo "$page: $link is not there"
    wrong=$((wrong + 1))
done <links
grep -q 'loop.gif' index.html || { echo "no picture on the first page"; wrong=$((wrong + 1)); }
echo "$(wc -l <links) links and pictures, $wrong broken"
[ -s links ] && [ $wrong -eq 0 ]

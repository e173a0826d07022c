# What the tests of the program share: asking it, and looking at its answers. Sourced with the
# program as the first argument; goes to a folder of its own, with a small scene in it.
program=$(realpath "${1:?usage: $0 PROGRAM}")
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder" || exit 1
failed=0

wrong() {
    echo "WRONG: $*"
    sed 's/^/    | /' said complained 2>/dev/null | head -n 20
    failed=$((failed + 1))
}
# answers CODE ARGUMENT...: the program ends with that exit code, and says what is wrong.
answers() {
    local expected=$1 code
    shift
    timeout 300 "$program" "$@" >said 2>complained </dev/null
    code=$?
    [ $code -eq "$expected" ] || wrong "exit $code instead of $expected: knead $*"
    case $expected in
        0 | 1) ;;  # 1: what differs is the answer
        *) [ -s complained ] || wrong "no word of what is wrong: knead $*" ;;
    esac
}
# The last answer's messages contain the text.
complains() { grep -qF -- "$1" complained || wrong "the complaint lacks: $1"; }
holds() { grep -qE -- "$2" "$1" || wrong "$1 lacks: $2"; }

cat >ball.json <<'SCENE'
{
    "schema": "knead.scene/1",  // comments are allowed
    "domain": {"edge": 0.32, "cells": 32},
    "objects": [{"shape": "sphere", "centre": [0.16, 0.16, 0.16], "diameter": 0.1,
                 "material": {"preset": "clay", "young": 1e5}, "category": 1}],
    "hands": {"recording": "squeeze"},
    "frame_rate": 90
}
SCENE

# Ends the test: 1 where anything was wrong.
concluded() {
    [ $failed -eq 0 ] && echo "the program answers as it should" || echo "$failed wrong"
    exit $((failed > 0))
}

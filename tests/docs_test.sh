#!/usr/bin/env bash
# What the pages name is there: paths, files, links, functions, scene keys, options. And no line of
# a page is wider than 100 columns. Prints every place that is wrong; fails if there is any.
# usage: tests/docs_test.sh
set -u
cd "$(dirname "$0")/.."
export LC_ALL=C.UTF-8
shopt -s nullglob globstar lastpipe

pages=({README,CHANGELOG,CONTRIBUTING,SECURITY}.md docs/{,*/}*.md
    {render,render/view,xr}/README.md {cuda,host,tests,profiling,scenes,examples}/**/README.md)
sources=({cuda,host,render,xr,tests,profiling,examples}/**/*.{h,cuh,cpp,cu,sh,py}
    CMakeLists.txt {cuda,host,render,xr,tests,profiling}/**/CMakeLists.txt cmake/*.cmake
    CMakePresets.json .clang-tidy *.sh)
rooms='(cuda|host|render|xr|tests|docs|scenes|profiling|examples|cmake)'

. tests/none.sh
# PAGE:LINE:WORD for every match of an expression in the pages.
words() { grep -noP -- "$1" "${pages[@]}"; }

# Wherever it stands, in prose or in a command. Braces and stars are the shell's.
words "(?<![\w/.<])$rooms/[\w./*{},-]*[\w/*}]" | while IFS=: read -r page line path; do
    eval "found=($path)"  # of letters, dots, stars and braces alone
    for one in "${found[@]}"; do [ -e "$one" ] || echo "$page:$line: $path"; done
    [ ${#found[@]} -gt 0 ] || echo "$page:$line: $path"
done | none "paths that are not there"

words '(?<=`)[\w-]+\.(h|cuh|cpp|cu|sh|py)(?=`)' | while IFS=: read -r page line file; do
    found=(**/"$file")
    [ ${#found[@]} -gt 0 ] || echo "$page:$line: $file"
done | none "files that are nowhere"

words '(?<=\]\()[^)#:]+(?=[)#])' | while IFS=: read -r page line link; do
    [ -e "$(dirname "$page")/$link" ] || echo "$page:$line: $link"
done | none "links to nothing"

# As GitHub and Doxygen make them of headings: small letters, blanks as dashes, no marks.
anchors() {
    grep -P '^#+ ' "$1" | sed -E 's/^#+ +//' | tr 'A-Z ' 'a-z-' | sed -E 's/[^[:alnum:]_-]//g'
}
words '(?<=\]\()[^):]*#[^)]+(?=\))' | while IFS=: read -r page line link; do
    file=${link%%#*}
    target=$page
    if [ -n "$file" ]; then target=$(dirname "$page")/$file; fi
    anchors "$target" 2>/dev/null | grep -qxF -- "${link#*#}" || echo "$page:$line: $link"
done | none "links to sections that are not there"

# `name()`, `Type::name`, a switch of the build or the environment.
words '(?<=`)([A-Za-z_]\w*::)*[A-Za-z_]\w*(?=\()(?=[^`]*\)`)|(?<=`)\w+(::\w+)+(?=`)|\bKNEAD_\w+' |
    while IFS=: read -r page line name; do
        grep -qw -- "${name##*:}" "${sources[@]}" || echo "$page:$line: $name"
    done | none "functions, types and switches that the code does not have"

words '(?<=`)[A-Z][a-z]\w+(?=`)' | while IFS=: read -r page line name; do
    grep -qw -- "$name" "${sources[@]}" || echo "$page:$line: $name"
done | none "types that the code does not have"

others='--(build|preset|install|prefix|gtest_\w+|target)\b'
words '(?<![\w-])--[a-z][\w-]+' | while IFS=: read -r page line option; do
    [[ $option =~ ^$others ]] || grep -qF -- "$option" "${sources[@]}" ||
        echo "$page:$line: $option"
done | none "options that no program has"

# The first column of the tables of docs/reference/formats.md, by the last part of each key.
grep -noP '^\| `[^|]*(?=\|)' docs/reference/formats.md | while IFS=: read -r line cell; do
    grep -oP '(?<=`)[\w.]+(?=(\.\*)?`)' <<<"$cell" | while read -r key; do
        grep -qF -- "\"${key##*.}\"" host/**/*.cpp host/**/*.h || echo "$line: $key"
    done
done | none "keys of docs/reference/formats.md that no code reads or writes"

# And the other way: what host/scene reads of a scene, the page has.
verbs='number|whole|flag|text|choice|vector|object|find|required|has'
cat host/scene/*.cpp | tr '\n' ' ' | grep -oP "\b(r|in|o)\.($verbs)(<\w+>)?\(\s*\"\w+" |
    sed 's/.*"//' | sort -u | while read -r key; do
        grep -qE "[\`.\"]$key[\`\"]" docs/reference/formats.md || echo "$key"
    done | none "keys of a scene that docs/reference/formats.md does not name"

grep -nE '^.{101,}' "${pages[@]}" | cut -c1-90 | none "lines of more than 100 columns"
grep -nP '\t| +$|\r' "${pages[@]}" | none "tabs or blanks at the end of a line"
grep -nE '/(home|root|work)/' "${pages[@]}" | none "paths of somebody's machine"

# The text of docs/reference/verify.md has figures of them: read it again when they change.
for picture in workprecision stability; do
    cmp -s "docs/$picture.png" "profiling/results/nvidia-h200/verify/$picture.png" ||
        echo "docs/$picture.png"
done | none "pictures that are not those of the newest report (docs/gallery.sh makes them)"

# Every room has a page that says what it is for.
for room in cuda/*/ host/*/ host/solver/*/ render/ render/view/ xr/ tests/ profiling/ scenes/; do
    [ -e "$room/README.md" ] || echo "$room"
done | none "rooms without a README.md"

if [ $failed -gt 0 ]; then
    echo "$failed rules broken"
    exit 1
fi
echo "${#pages[@]} pages name what is there"

#!/usr/bin/env bash
# What the program writes for shells completes its verbs, their options and the words of its lists,
# in bash and, where there is one, in zsh.
# usage: tests/cli/completion_test.sh PROGRAM
set -u
. "$(dirname "$0")"/answers.sh

answers 0 help --completion bash
bash -n said || wrong "completion that bash does not read"
completed() {  # WORD...: the last is completed
    bash -c 'source said; knead() { "'"$program"'" "$@"; }; COMP_WORDS=("$@")
        COMP_CWORD=$(($# - 1)); _knead; printf "%s\n" "${COMPREPLY[@]}"' _ "$@"
}
completed knead ru | grep -qx run || wrong "no completion of a verb"
completed knead run --devi | grep -qx -- --device || wrong "no completion of an option"
completed knead record sque | grep -qx squeeze || wrong "no completion of a gesture"
answers 0 help --completion zsh
if ! command -v zsh >/dev/null; then
    echo "no zsh here: its completion was not tried"
    concluded
fi
mkdir -p functions programs
mv said functions/_knead
ln -sf "$program" programs/knead
# As at a terminal: each line is completed, and what it then is goes to `lines`.
cat >complete.zsh <<'ZSH'
zmodload zsh/zpty
zpty shell zsh -f -i
zpty -w shell 'path=($PWD/programs $path) fpath=($PWD/functions $fpath)
    autoload -U compinit; compinit -u -D
    told() { zle complete-word; print -r -- "$BUFFER" >>lines; BUFFER= }
    zle -N told; bindkey "^T" told; : >lines'
until [[ -e lines ]] || (( tries++ > 100 )); do sleep 0.1; done
for line in "knead rec" "knead run --dev" "knead record pin" "knead vr sque" "knead info --js"; do
    zpty -w -n shell "$line"$'\x14'
    (( lines_due++, tries = 0 ))
    until (( $(wc -l <lines) == lines_due || tries++ > 100 )); do sleep 0.1; done
done
while zpty -r -t shell text; do print -r -- "$text"; done >shown
zpty -d shell
ZSH
zsh -f complete.zsh </dev/null
printf '%s\n' 'knead record ' 'knead run --device ' 'knead record pinch ' 'knead vr squeeze ' \
    'knead info --json ' >due
cmp -s due lines || wrong "zsh completes otherwise: $(cat lines shown)"
concluded

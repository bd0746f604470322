#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# manual.sh FEWRAY FOLDER: every option that a command's --help tells stands in its manual page and in the completion of each
# shell; bash completes; pages pass mandoc's checks where it is there.
set -eu
fewray=$1 folder=$2
fail() { echo "$*" >&2; exit 1; }

count=0
for command in $("$fewray" --help | sed -n '/^commands:/,/^$/s/^  \([a-z]*\) .*/\1/p'); do
    page=$folder/fewray-$command.1
    for option in $("$fewray" "$command" --help | sed -n 's/^ *\(-[a-z], \)*--\([a-z0-9-]*\).*/\2/p'); do
        roff=$(printf %s "$option" | sed 's/-/\\\\-/g')
        grep -q -e "--$roff\\\\f\|\\\\-\\\\-$roff\\\\f" "$page" || fail "$page lacks --$option"
        grep -q -e "\"$command -\"\*).*--$option[ \"]" "$folder/fewray.bash" || fail "bash lacks $command --$option"
        sed -n "/^$command)/,/^    ;;/p" "$folder/fewray.zsh" | grep -q -e "--$option[=[}]" || fail "zsh lacks $command --$option"
        grep -q -e "from $command'.* -l $option " "$folder/fewray.fish" || fail "fish lacks $command --$option"
        count=$((count + 1))
    done
    grep -q "fewray\\\\-$command" "$folder/fewray.1" || fail "fewray.1 lacks $command"
done
[ "$count" -gt 60 ] || fail "only $count options were found"

# completes WORD... = EXPECTED: what bash offers for the last word.
completes() {
    expected=$1
    shift
    found=$(bash -c '. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _fewray; echo ${COMPREPLY[*]}' - \
        "$folder/fewray.bash" "$@")
    [ "$found" = "$expected" ] || fail "bash completes '$*' by '$found', not '$expected'"
}
completes render fewray ren
completes "--guide --guide-weights" fewray render --guide
completes "off odis paper ppg" fewray render --guide ""
completes fast fewray render --model f
scratch=$(mktemp -d)
trap 'rm -r "$scratch"' EXIT
touch "$scratch/a.exr" "$scratch/b.txt"
completes "$scratch/a.exr" fewray compare "$scratch/"

grep -q '[*]\.([a-z]*)' "$folder/fewray.zsh" && fail "zsh takes (ENDING) alone for qualifiers of its pattern, not for an ending"
for shell in zsh fish; do
    if command -v "$shell" >/dev/null; then "$shell" -n "$folder/fewray.$shell" || fail "$shell can't read its completion"; fi
done
if command -v mandoc >/dev/null; then
    for page in "$folder"/*.1; do
        mandoc -T lint -W warning "$page" || fail "$page: see above"
    done
fi
echo "$count options"

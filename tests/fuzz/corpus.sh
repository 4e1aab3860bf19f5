#!/usr/bin/env bash
# A target's corpus is one file, corpus/TARGET.txt: an input a line, base64. libFuzzer wants a folder of files.
#
#   tests/fuzz/corpus.sh unpack TARGET FOLDER     writes the inputs into FOLDER
#   tests/fuzz/corpus.sh pack TARGET FOLDER       makes the inputs in FOLDER the corpus (after fuzz_TARGET -merge=1)
set -euo pipefail
corpus="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)/corpus"
[ $# = 3 ] || { sed -n '2,5s/^# \{0,1\}//p' "${BASH_SOURCE[0]}" >&2; exit 2; }
case $1 in
    unpack)
        mkdir -p "$3"
        number=0
        while read -r line; do
            base64 -d <<<"$line" >"$3/seed-$number"
            number=$((number + 1))
        done <"$corpus/$2.txt"
        ;;
    pack)
        for file in "$3"/*; do base64 -w0 "$file"; echo; done | LC_ALL=C sort -u | grep . >"$corpus/$2.txt"
        ;;
    *) echo "expected unpack or pack, found '$1'" >&2; exit 2 ;;
esac

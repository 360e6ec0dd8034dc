#!/usr/bin/env bash
# check_symbols.sh OBJDIR - every external symbol carries the prefix of its file's header.
#
# bvh_build.c may define bvh_* (its stem up to the first underscore) and NAME_* for each header NAME.h beside it whose
# name its own begins with: http_client.c has http_client_*. A file with a main has nothing else. tests/tap.c
# is the exception: `ok` should stay short. Names with two underscores in front are the
# compiler's (sanitizers, coverage). --self-test shows that a stray symbol is found.
# SPDX-License-Identifier: MIT
set -u
self=$(readlink -f "$0")

check() { # OBJDIR
    local objects
    objects=$(find "$1" -name '*.o' | while read -r o; do
        source=${o#"$1"/}
        [ -f "${source%.o}.c" ] && echo "$o" # an object whose source is gone is none of ours
    done)
    [ -n "$objects" ] || { echo "no objects under $1: run make first"; return 1; }
    # shellcheck disable=SC2086
    nm -A -g -P --defined-only $objects | awk -v root="$1/" -v headers="$(find . -name '*.h' -not -path './build/*')" '
        BEGIN {
            for (n = split(headers, list, "\n"); n > 0; n--) {
                sub(/^\.\//, "", list[n]); sub(/\.h$/, "", list[n]); header[list[n]] = 1
            }
        }
        function allowed(file, symbol,    dir, stem, first, h) {
            stem = file; sub(/.*\//, "", stem); dir = substr(file, 1, length(file) - length(stem))
            first = stem; sub(/_.*/, "", first)
            if (symbol == first || index(symbol, first "_") == 1) return 1
            for (h = stem; h != ""; h = (h ~ /_/ ? substr(h, 1, match(h, /_[^_]*$/) - 1) : ""))
                if ((dir h) in header && (symbol == h || index(symbol, h "_") == 1)) return 1
            return 0
        }
        {
            file = $1; sub(/:$/, "", file); sub(/\.o$/, "", file); file = substr(file, length(root) + 1)
            if ($2 ~ /^__/ || file == "tests/tap") next
            program = file ~ /(^|\/)main$|^(tests\/(test|tool|fuzz)|bench\/bench)_/
            if (program ? $2 == "main" || $2 == "LLVMFuzzerTestOneInput" : $2 != "main" && allowed(file, $2)) next
            printf "%s.c: external symbol %s %s\n", file, $2, program ? "should be static" : "does not carry its header'\''s prefix"
            bad = 1
        }
        END { exit bad }'
}

self_test() {
    local found failed=0
    dir=$(mktemp -d) && trap 'rm -rf "$dir"' EXIT
    mkdir -p "$dir/common" "$dir/build/common"
    cd "$dir" || return 2
    touch common/long_name.h
    build() { # FILE CODE
        find . -name '*.[co]' -delete
        printf '%s\n' "$2" >"$1.c"
        "${CC:-cc}" -c -o "build/$1.o" "$1.c"
    }
    expect() { # FILE CODE FOUND
        build "$1" "$2"
        found=$(CHECK_ROOT=$dir "$self" "$dir/build" | grep -c 'external symbol')
        [ "$found" = "$3" ] || { echo "self-test: $1.c '$2': $found found, not $3"; failed=1; }
    }
    expect common/film_sum 'int film_a; int film_b(void) { return 0; } static int c; int *film_c(void) { return &c; }' 0
    expect common/long_name_part 'int long_name_a; int long_b;' 0
    expect common/film 'int stray(void) { return 0; }' 1
    expect common/film 'int filmed; int main(void) { return 0; }' 2
    expect common/main 'int main(void) { return 0; }' 0
    expect common/main 'int main_helper; int main(void) { return 0; }' 1
    return $failed
}

case ${1-} in
--self-test) self_test ;;
'' | -*) echo "usage: $0 OBJDIR | --self-test" >&2; exit 2 ;;
*) cd "${CHECK_ROOT:-$(dirname "$self")/..}" && check "${1%/}" ;;
esac

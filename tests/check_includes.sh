#!/usr/bin/env bash
# check_includes.sh - who may include whom, what the pure parts may call, and a few habits.
#
# Each rule is one grep over the sources without their comments, as lines of "file:line:code". A hit is
# printed with the rule it breaks; the exit status is 1 when there was any. --self-test plants one violation of each rule in a
# temporary directory and demands that it is found, and that a clean tree passes.
# SPDX-License-Identifier: MIT
set -u
self=$(readlink -f "$0")
cd "${CHECK_ROOT:-$(dirname "$self")/..}" || exit 2
tmp=$(mktemp -d) && trap 'rm -rf "$tmp"' EXIT
code=$tmp/code found=$tmp/found # found: what broke a rule; rules run in pipelines, so a variable would be lost

sources() { # what is ours: in a checkout what git knows or would add, else every file
    git ls-files --cached --others --exclude-standard 2>/dev/null ||
        find . -type f -not -path './build/*' | sed 's,^\./,,'
}

# Comments become blanks, so that words in them break no rule; line numbers stay.
strip_comments() {
    perl -0777 -ne 's{("(?:\\.|[^"\\\n])*"|\x27(?:\\.|[^\x27\\\n])*\x27)|(/\*.*?\*/|//[^\n]*)}
                      {defined $1 ? $1 : $2 =~ s/[^\n]//gr}gsex;
                    my $n = 0; print map {$n++; "$ARGV:$n:$_\n"} split /\n/' "$@"
}

report() { # MESSAGE, hits on stdin
    local hit
    while read -r hit; do
        printf '%s: %s\n' "$1" "$hit" | tee -a "$found"
    done
}

# forbid MESSAGE FILES CODE [EXCEPT]: extended regular expressions; EXCEPT is of whole hits
forbid() {
    grep -E "^($2):[0-9]+:.*($3)" "$code" | { [ $# -gt 3 ] && grep -vE "$4" || cat; } | report "$1"
}

# library NAME HEADER FILES: where an outside library may be included
library() {
    forbid "$1 is included only by ${3//\\/}" '(common|server|worker|client)/.*' "# *include *<$2" "^($3):"
}

include='# *include *"'

check_layers() {
    forbid 'server may include only server and common' 'server/.*' "$include" "$include(server|common)/[^/]*\""
    forbid 'worker may include only worker, common and common/trace' 'worker/.*' "$include" \
        "$include(worker|common|common/trace)/[^/]*\""
    forbid 'client may include only client, common and common/trace' 'client/.*' "$include" \
        "$include(client|common|common/trace)/[^/]*\""
    forbid 'common may include only common' 'common/[^/]*' "$include" "$include""common/[^/]*\""
    forbid 'common/trace may include only itself and common/{base,err,arena,vec,color,scene,tile,film,layers,plan}.h' \
        'common/trace/.*' "$include" \
        "$include""common/(trace/[^/]*|base\.h|err\.h|arena\.h|vec\.h|color\.h|scene\.h|tile\.h|film\.h|layers\.h|plan\.h)\""
}

check_libraries() {
    library libmicrohttpd 'microhttpd' 'server/http\.c'
    library libcurl 'curl/' 'common/http_client\.c'
    library SQLite 'sqlite3' 'server/store\.c'
    library zlib 'zlib' 'common/wire\.c'
    library libcrypto 'openssl/' 'common/hash\.c'
    library OpenEXR '(openexr|OpenEXR/)' '(server/image_exr|common/exr_file)\.c'
    library xxHash 'xxhash' 'worker/stagefile\.c'
    library libpng 'png\.h' '(server/image_png|common/image_asset_png)\.c'
    library libjpeg 'jpeglib' 'common/image_asset_jpeg\.c'
    library jansson 'jansson' \
        '(common/(scene_json|http_problem)|server/(api|body|feed|grant|problem|status)[a-z_]*|worker/link|client/[a-z_]+)\.c'
    forbid 'Embree is included only by bench/embree.c' '.*' '# *include *<embree' '^bench/embree\.c:'
    forbid 'no header may include an outside library' '[^:]*\.h' \
        '# *include *<(microhttpd|curl/|sqlite3|zlib|openssl/|openexr|OpenEXR/|png\.h|jpeglib|jansson|xxhash)'
}

check_purity() {
    local trace='common/trace/.*'
    forbid 'common/trace uses its own elementary functions (fmath.h), not libm' "$trace" \
        '(^|[^_[:alnum:]])(__builtin_)?(a?(sin|cos|tan)h?|atan2|sincos|exp|exp2|exp10|expm1|log|log2|log10|log1p|pow|cbrt|hypot|[lt]gamma|erfc?)[fl]? *\('
    forbid 'common/trace: gcc makes calls of these; write (a < b ? a : b)' "$trace" '(^|[^_[:alnum:]])(__builtin_)?f(min|max)[fl]? *\('
    forbid 'common/trace takes its square roots by __builtin_sqrtf' "$trace" '(^|[^_[:alnum:]])sqrt[fl]? *\('
    forbid 'common/trace takes memory from an arena' "$trace" '(^|[^_[:alnum:]])(malloc|calloc|realloc|free|alloca) *\('
    forbid 'common/trace does no I/O, has no threads and reads no clock' "$trace" \
        '# *include *<(stdio|time|unistd|fcntl|errno|pthread|threads|stdatomic|signal|locale|dirent|sys/.*|x86intrin|complex)\.?h?>'
    forbid 'common/trace depends on nothing but its arguments' "$trace" \
        '(^|[^_[:alnum:]])(getenv|rand|srand|random|drand48|time|clock|clock_gettime|gettimeofday|getpid|pthread_self|qsort|setlocale|fesetround|printf|fprintf) *\('
    forbid 'this file performs no I/O and reads no clock: bytes and time are arguments' \
        '(common/(scene_[a-z]+|wire|film|tile|plan|estimate)|server/(sched|lease|merge))\.c' \
        '(^|[^_[:alnum:]])(fopen|fread|fwrite|fprintf|printf|open|read|write|mmap|time|clock_[a-z_]+|gettimeofday|getenv) *\('
    forbid 'only common/clock.c and common/log.c read a clock' '(common|server|worker|client)/.*' \
        '(^|[^_[:alnum:]])(clock_gettime|gettimeofday|time|clock) *\(' '^common/(clock|log)\.c:'
    forbid 'intrinsics belong in common/trace/simd.h' '(common|server|worker|client)/.*' \
        '_mm[0-9]*_[a-z]|__m(128|256|512)|__builtin_ia32|# *include *<[a-z]*intrin\.h>' '^common/trace/simd\.h:'
}

check_habits() {
    forbid 'structs and enums have no typedef' '.*' 'typedef +(struct|enum|union)[ {]'
    # The letter in brackets keeps these lines from finding themselves.
    sources | xargs grep -nIE '(TOD[O]|FIXM[E]|XX[X]):?( |$)' 2>/dev/null | report 'on the main branch it is an issue, or it is done'
    sources | xargs grep -nIE '(^|[^[:alnum:]_.$}/-])/(wor[k]|hom[e]|roo[t]|User[s])/' 2>/dev/null |
        report 'a path of somebody'\''s machine'
    for file in $(sources | grep -E '\.[ch]$'); do
        [ -f "$file" ] || continue
        [ "$(wc -l <"$file")" -gt 500 ] && echo "$file:501:" | report 'longer than 500 lines'
        grep -q 'SPDX-License-Identifier: MIT' "$file" || echo "$file:1:" | report 'no SPDX line'
        case $file in
        *.h)
            guard=${file//[\/.]/_}
            grep -qx "#ifndef ${guard^^}" "$file" || echo "$file:1:" | report "the guard should be ${guard^^}"
            ;;
        *.c) # its own header first proves that the header compiles alone
            own=${file%.c}.h
            [ ! -f "$own" ] || [ "$(grep -m1 '^# *include' "$file")" = "#include \"$own\"" ] ||
                echo "$file:1:" | report "its own header comes first"
            ;;
        esac
    done
}

check() {
    # shellcheck disable=SC2046
    strip_comments $(sources | grep -E '^(common|server|worker|client|tests|bench)/.*\.[ch]$') >"$code"
    : >"$found"
    check_layers
    check_libraries
    check_purity
    check_habits
    [ ! -s "$found" ]
}

self_test() {
    local dir=$tmp/tree failed=0 file line
    mkdir -p "$dir"/{common/trace,server,worker,client,bench}
    clean() {
        find "$dir" -type f -delete
        printf '%s\n' '/* a.h: sin(x), time() and TO''DO-free words in comments break nothing' \
            ' * SPDX-License-Identifier: MIT */' '#ifndef COMMON_A_H' '#define COMMON_A_H' '#endif' >"$dir/common/a.h"
    }
    clean
    CHECK_ROOT=$dir "$self" >/dev/null || { echo "self-test: a clean tree does not pass"; failed=1; }
    while IFS='|' read -r file line; do
        clean
        printf '/* SPDX-License-Identifier: MIT */\n%s\n' "$line" >"$dir/$file"
        if CHECK_ROOT=$dir "$self" | grep -q ": $file:"; then continue; fi
        echo "self-test: not found: $file: $line"
        failed=1
    done <<'END'
server/a.c|#include "worker/link.h"
server/a.c|#include "common/trace/ray.h"
worker/a.c|#include "client/cmd.h"
client/a.c|#include "server/job.h"
common/b.c|#include "common/trace/ray.h"
common/b.c|#include "server/job.h"
common/trace/a.c|#include "common/wire.h"
server/a.c|#include <microhttpd.h>
server/main.c|#include <jansson.h>
common/b.c|#include <curl/curl.h>
bench/a.c|#include <embree3/rtcore.h>
common/b.h|#include <zlib.h>
worker/a.c|#include <xxhash.h>
common/trace/a.c|float a(float x) { return sinf(x); }
common/trace/a.c|float a(float x) { return fminf(x, 1.0f); }
common/trace/a.c|float a(float x) { return sqrtf(x); }
common/trace/a.c|void *a(void) { return malloc(1); }
common/trace/a.c|#include <stdio.h>
common/trace/a.c|int a(void) { return getenv("A") != 0; }
common/wire.c|int a(void) { return open("a", 0); }
server/a.c|long a(void) { return time(0); }
common/trace/a.c|__m256 a(__m256 x) { return _mm256_add_ps(x, x); }
common/b.c|typedef struct b { int c; } b;
common/b.h|#ifndef WRONG_H
END
    for line in 'TO''DO: later' 'see /ho''me/somebody/file'; do
        clean
        echo "/* SPDX-License-Identifier: MIT $line */" >"$dir/common/b.c"
        CHECK_ROOT=$dir "$self" | grep -q ': common/b.c:' || { echo "self-test: not found: $line"; failed=1; }
    done
    return $failed
}

case ${1-} in
--self-test) self_test ;;
'') check ;;
*) echo "usage: $0 [--self-test]" >&2; exit 2 ;;
esac

#!/usr/bin/env bash
# check_rows.sh - docs/accuracy.md says for each row of its table which tests check it, and they do.
#
# A check of row F-12 is a string in tests/test_*.c or tests/stat/*.c that begins with "F-12: " (or names several: "A-14, F-23: "). The table
# is what stands between the lines "<!-- rows -->" and "<!-- end of rows -->": each row's tests must have such a string,
# and each test that has one must stand in the row. SPDX-License-Identifier: MIT
set -u
cd "$(dirname "$0")/.." || exit 2

claimed=$(sed -n '/^<!-- rows -->$/,/^<!-- end of rows -->$/p' docs/accuracy.md | awk -F'|' '
    $2 ~ /^ [AF]-[0-9][0-9] $/ {
        row = $2; gsub(/ /, "", row)
        for (n = split($NF == "" ? $(NF - 1) : $NF, list, "`"); n > 0; n--)
            if (list[n] ~ /^(stat\/|test_)/) print row, list[n]
    }' | sort -u)
found=$(grep -oHE '"[AF]-[0-9]{2}(, [AF]-[0-9]{2})*: ' tests/test_*.c tests/stat/*.c | awk -F: '{
        file = $1; sub(/^tests\//, "", file); sub(/\.c$/, "", file); rows = $2; gsub(/[" ]/, "", rows)
        for (n = split(rows, list, ","); n > 0; n--) print list[n], file
    }' | sort -u)
[ -n "$claimed" ] || { echo "docs/accuracy.md: no table of rows"; exit 1; }
bad=$(diff <(echo "$claimed") <(echo "$found") |
    sed -n 's/^< \(.*\) \(.*\)/docs\/accuracy.md: \1 is said to be checked by \2, which has no check of that name/p
            s/^> \(.*\) \(.*\)/docs\/accuracy.md: \1 does not name \2, which checks it/p')
[ -z "$bad" ] || { echo "$bad"; exit 1; }

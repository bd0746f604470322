#!/bin/sh
# SPDX-License-Identifier: Apache-2.0
# Sums up the logs of fuzzers: sum.sh FOLDER. Their names are TARGET-ANYTHING.log. Prints a row for each target, and
# what all of them come to; fails where a log tells of a crash, or there is none.
set -eu
cd "$1"
for log in *-*.log; do
    [ -e "$log" ] || { echo "there are no logs in $1" >&2; exit 1; }
    tr '\r' '\n' < "$log" | awk -v target="${log%%-*}" '
        /stat::number_of_executed_units/ { runs = $2; whole = 1 }
        /^#[0-9]+/ { n = substr($1, 2) + 0; if (n > last) last = n
                     for (i = 2; i < NF; i++) {
                         if ($i == "cov:") cov = $(i + 1)
                         if ($i == "corp:") { split($(i + 1), c, "/"); corpus = c[1] }
                         if ($i == "exec/s:" && $(i + 1) > 0) rate = $(i + 1) } }
        /^Done [0-9]+ runs in [0-9]+ second/ { seconds = $5 }
        /^SUMMARY: / { crashes++ }
        END { if (!runs) runs = last
              if (!seconds && rate) seconds = runs / rate # of a fuzzer that was ended, or still runs
              printf "%s %d %.0f %d %d %d\n", target, runs, seconds, cov, corpus, crashes }'
done | sort -s -k1,1 | awk '
    BEGIN { printf "%-12s %14s %10s %8s %8s %8s %8s\n", "target", "executions", "seconds", "exec/s", "edges", "corpus", "crashes" }
    function row(name, n, s, e, c, x) {
        printf "%-12s %14d %10d %8d %8d %8d %8d\n", name, n, s, (s > 0 ? n / s : 0), e, c, x }
    function finish() { if (name) row(name, n, s, e, c, x); n = s = e = c = x = 0 }
    $1 != name { finish(); name = $1 }
    { n += $2; s += $3; all_n += $2; all_s += $3; x += $6; all_x += $6
      if ($4 > e) e = $4
      if ($5 > 0) c = $5 }
    END { finish(); printf "all: %.2f hours, %d executions, %d crashes\n", all_s / 3600, all_n, all_x
          exit all_x > 0 }'

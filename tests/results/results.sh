# shellcheck shell=bash
# Runs ctest and reports its results. Sourced by tests/run, tests/sanitizers and .ci/run.

# A test in real time needs a processor. More failures than this have another reason than
# the tests beside it, unless the host took a tenth of the processors' time. A computer that
# did everything at a third of its speed failed 14 of 6874.
few_failures=25

# Jiffies of all processors so far: those that they worked, and those that the host of this
# virtual computer took from them.
worked_and_stolen() { awk '/^cpu /{print $2 + $3 + $4 + $7 + $8, $9}' /proc/stat; }

# Prints the share of the processors' time that the host took since then, in percent.
stolen_percent() { # WORKED_THEN STOLEN_THEN
  local worked stolen
  read -r worked stolen < <(worked_and_stolen)
  echo $((100 * (stolen - $2) / (worked - $1 + stolen - $2 + 1)))
}

# Prints the names of the tests with this result.
tests_that() { # passed|failed|skipped LOG_OF_CTEST
  local all='^ *[0-9]+/[0-9]+ Test +#[0-9]+: (.*[^ ]) \.+'
  local skipped='\*\*\*(Skipped|Not Run \(Disabled\))'
  case $1 in
    passed) sed -nE "s@$all +Passed .*@\1@p" "$2" ;;
    skipped) sed -nE "s@$all$skipped.*@\1@p" "$2" ;;
    failed) sed -nE "/$skipped/d; s@$all\*\*\*.*@\1@p" "$2" ;;
  esac
}

# Prints both results of each test that was run again, and how many there are.
report_second_runs() { # LOG LOG_OF_THE_SECOND_RUN
  local name passed flaky=0 twice=0
  passed=$(tests_that passed "$2")
  while read -r name; do
    if grep -qxF -- "$name" <<< "$passed"; then
      flaky=$((flaky + 1))
      echo "flaky: $name failed, then passed alone"
    else
      twice=$((twice + 1))
      echo "failed twice: $name failed, then failed alone"
    fi
  done < <(tests_that failed "$1")
  echo "$((flaky + twice)) tests were run again: $flaky flaky, $twice failed twice"
}

# Prints a line for each test: its name, a tab, and why it was skipped, if it was: what
# GoogleTest prints below "Skipped", or the last line of a script.
reasons() { # LOG_OF_CTEST_WITH_ALL_OUTPUT
  awk '
    / Testing: / { sub(/^[^:]*: /, ""); name = $0; reason = ""; last = ""; below = 0; next }
    /^<end of output>$/ { print name "\t" (reason != "" ? reason : last) }
    /^-+$/ { last = ""; next }
    below { reason = $0; below = 0 }
    /: Skipped$/ && reason == "" { below = 1 }
    /[^ ]/ { last = $0 }' "$1"
}

# Prints how many tests were skipped for each reason, the most frequent first.
report_skipped() { # LOG LOG_OF_CTEST_WITH_ALL_OUTPUT
  local name reason
  local -A why=()
  while IFS=$'\t' read -r name reason; do why[$name]=$reason; done < <(reasons "$2")
  while read -r name; do
    echo "${why[$name]:-it gives no reason}"
  done < <(tests_that skipped "$1") | sort | uniq -c | sort -k1,1rn -k2 |
    sed -E 's/^ *([0-9]+) (.*)/skipped: \1 because: \2/'
}

# Prints the ten tests that took longest, in one line. All lines are read to their end: a
# program that is still writing when its reader ends (as with head) fails the whole pipe.
report_slowest() { # LOG
  sed -nE 's@^ *[0-9]+/[0-9]+ Test +#[0-9]+: (.*[^ ]) \.+.* ([0-9.]+) sec.*@\2 \1@p' "$1" |
    sort -k1,1rn |
    sed -nE '1,10{s/^([^ ]+) (.*)/\2 \1 s/p}' |
    paste -sd ',' | sed 's/,/, /g; s/^/slowest: /'
}

# Prints the closing line. The reports of sanitizers count as one test, because a process
# that a test starts and kills can write one without a test that fails. Flaky tests, if there
# are any, are counted apart from those that passed.
closing_line() { # LOG FAILED_COUNT FLAKY_COUNT FOLDER_OF_SANITIZER_REPORTS
  local passed skipped failed=$2 flaky=$3
  skipped=$(tests_that skipped "$1" | wc -l)
  passed=$(($(tests_that passed "$1" | wc -l) + $(tests_that failed "$1" | wc -l)))
  passed=$((passed - failed - flaky))
  if [[ -d $4 ]]; then
    if [[ -z $(ls "$4") ]]; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
  fi
  print_counts "$passed" "$failed" "$skipped" "$flaky"
}

print_counts() { # PASSED FAILED SKIPPED FLAKY
  local flaky=""
  [[ $4 -eq 0 ]] || flaky=", $4 flaky"
  echo "$1 passed, $2 failed, $3 skipped$flaky"
}

# Runs ctest, two tests at a time for each processor, for the longest mostly wait for a machine
# in real time: all tests together need half of what two processors give in that time. What failed runs once more, alone, when that is few, or the host
# took a tenth of the processors' time or more. Prints the tests that were run twice with both
# results, those that were skipped with their reasons, the slowest and, as the last line, the
# closing line; all are kept in BUILD/tests.summary. Fails when a test failed (twice, if it was run twice) or a sanitizer
# reported.
run_tests() { # BUILD [ARGUMENTS OF CTEST]
  local build=$1 log=$1/tests.log again=$1/tests_again.log reports=$1/reports
  local outputs=$1/tests_outputs.log summary=$1/tests.summary
  local status=0 worked stolen taken failed flaky=0
  shift
  rm -f "$summary" "$again" "$reports"/*
  read -r worked stolen < <(worked_and_stolen)
  run_ctest "$build" -j $((2 * $(nproc))) "$@" 2>&1 | tee "$log" || status=$?
  taken=$(stolen_percent "$worked" "$stolen")
  cp "$build/Testing/Temporary/LastTest.log" "$outputs" || : > "$outputs"
  failed=$(tests_that failed "$log" | wc -l)
  : > "$summary"
  if [[ $failed -gt 0 && ($failed -le $few_failures || $taken -ge 10) ]]; then
    echo "$failed failed, and the host took $taken % of the processors' time: again, alone"
    status=0
    run_ctest "$build" --rerun-failed "$@" 2>&1 | tee "$again" || status=$?
    report_second_runs "$log" "$again" > "$summary"
    failed=$(grep -c '^failed twice: ' "$summary" || true)
    flaky=$(grep -c '^flaky: ' "$summary" || true)
  fi
  if [[ -d $reports && -n $(ls "$reports") ]]; then
    cat "$reports"/*
    status=1
  fi
  {
    report_skipped "$log" "$outputs"
    report_slowest "$log"
    closing_line "$log" "$failed" "$flaky" "$reports"
  } >> "$summary"
  cat "$summary"
  return "$status"
}

# test_path: the PATH of the tests, if it is another than this.
run_ctest() { # BUILD [ARGUMENTS OF CTEST]
  PATH=${test_path:-$PATH} ctest --test-dir "$1" --timeout 300 --output-on-failure --no-label-summary \
    --no-tests=error "${@:2}"
}

# Prints what run_tests kept of the given build directories, each line with its directory's
# name, and one closing line with the sums. Fails when one of them has no results.
sum_up() { # BUILD...
  local build line passed=0 failed=0 skipped=0 flaky=0 status=0
  local counts='^([0-9]+) passed, ([0-9]+) failed, ([0-9]+) skipped(, ([0-9]+) flaky)?$'
  for build in "$@"; do
    if [[ ! -e $build/tests.summary ]]; then
      echo "${build##*/}: no results"
      status=1
      continue
    fi
    while read -r line; do
      echo "${build##*/}: $line"
      [[ $line =~ $counts ]] || continue
      passed=$((passed + BASH_REMATCH[1]))
      failed=$((failed + BASH_REMATCH[2]))
      skipped=$((skipped + BASH_REMATCH[3]))
      flaky=$((flaky + ${BASH_REMATCH[5]:-0}))
    done < "$build/tests.summary"
  done
  print_counts "$passed" "$failed" "$skipped" "$flaky"
  return "$status"
}

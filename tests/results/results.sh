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

# Prints a line for each result: passed, failed or skipped, how many tests it counts as, the
# seconds that it took, its name, and why it was skipped: what GoogleTest prints below
# "Skipped", or the last line of a script. An entry "All of PROGRAM" ran all cases of a program
# of GoogleTest: each case is a result, and so is the one that was at work when the program
# ended early. The entry itself counts as a test only when it failed and its cases do not say
# why, or some did not run.
results_in() { # LOG_OF_CTEST LOG_WITH_ALL_OUTPUT
  awk -v OFS='\t' '
    function ended(result, name, seconds) {
      print result, 1, seconds, name, (result == "skipped" ? reason : "")
      failed_cases += result == "failed"
      --open
      at_work = reason = last = ""
    }
    FNR == NR {
      if (!match($0, /^ *[0-9]+\/[0-9]+ Test +#[0-9]+: /)) next
      name = substr($0, RLENGTH + 1)
      if (!match(name, / +[0-9.]+ sec *$/)) next
      seconds = substr(name, RSTART) + 0
      name = substr(name, 1, RSTART - 1)
      result = "failed"
      if (name ~ /\. +Passed$/) result = "passed"
      if (name ~ /\*\*\*(Skipped|Not Run \(Disabled\))$/) result = "skipped"
      sub(/ \.+([A-Za-z ]*\*\*\*.*| +Passed)$/, "", name)  # e.g. Subprocess killed***Exception:
      results[name] = result; took[name] = seconds; names[++count] = name
      next
    }
    /^[0-9]+\/[0-9]+ Testing: / {
      sub(/^[^:]*: /, "")
      entry = $0; all = entry ~ /^All of /
      at_work = reason = last = ""; below = failed_cases = open = 0
      next
    }
    /^<end of output>$/ {
      if (!(entry in results)) next
      if (all) {
        if (at_work != "") ended(results[entry], at_work, 0)
        silent = results[entry] == "failed" && (!failed_cases || open > 0)
        print results[entry], silent + 0, took[entry], entry, ""
      } else {
        if (reason == "") reason = last
        ended(results[entry], entry, took[entry])
      }
      delete results[entry]
      next
    }
    all && /\[==========\] Running [0-9]+ test/ { open = $3; next }
    all && match($0, /\[ RUN      \] /) {
      if (at_work != "") ended(results[entry], at_work, 0)
      at_work = substr($0, RSTART + RLENGTH)
      next
    }
    all && at_work != "" && match($0, /\[ (      OK| FAILED | SKIPPED) \] .*\([0-9]+ ms\)$/) {
      word = substr($0, RSTART + 2, 8)
      match($0, /\([0-9]+ ms\)$/)
      ended(word ~ /OK/ ? "passed" : word ~ /FAILED/ ? "failed" : "skipped", at_work,
            substr($0, RSTART + 1) / 1000)
      next
    }
    /^-+$/ { last = ""; next }
    below { reason = $0; below = 0 }
    /: Skipped$/ && reason == "" { below = 1 }
    /[^ ]/ { last = $0 }
    END {
      for (i = 1; i <= count; ++i)
        if (names[i] in results) print results[names[i]], 1, took[names[i]], names[i], ""
    }' "$1" "$2"
}

# Prints the names of the tests with this result.
tests_that() { # passed|failed|skipped RESULTS
  awk -F '\t' -v result="$1" '$1 == result && $2 > 0 { print $4 }' "$2"
}

# Prints both results of each test that was run again, and how many there are.
report_second_runs() { # RESULTS RESULTS_OF_THE_SECOND_RUN
  local name passed flaky=0 twice=0
  passed=$(awk -F '\t' '$1 == "passed" { print $4 }' "$2")
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

# Prints how many tests were skipped for each reason, the most frequent first.
report_skipped() { # RESULTS
  awk -F '\t' '$1 == "skipped" { print $5 == "" ? "it gives no reason" : $5 }' "$1" |
    sort | uniq -c | sort -k1,1rn -k2 |
    sed -E 's/^ *([0-9]+) (.*)/skipped: \1 because: \2/'
}

# Prints the ten tests that took longest, in one line. All lines are read to their end: a
# program that is still writing when its reader ends (as with head) fails the whole pipe.
report_slowest() { # RESULTS
  awk -F '\t' '$2 > 0 && $1 != "skipped" { printf "%.2f %s\n", $3, $4 }' "$1" | sort -s -k1,1rn |
    sed -nE '1,10{s/^([^ ]+) (.*)/\2 \1 s/p}' |
    paste -sd ',' | sed 's/,/, /g; s/^/slowest: /'
}

# Prints the closing line. The reports of sanitizers count as one test, because a process
# that a test starts and kills can write one without a test that fails. Flaky tests, if there
# are any, are counted apart from those that passed.
closing_line() { # RESULTS FAILED_COUNT FLAKY_COUNT FOLDER_OF_SANITIZER_REPORTS
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

# Runs ctest, two tests at a time for each processor: one computes, and gives way to the other,
# which mostly waits for a machine in real time; behind those that compute two that wait. What
# failed runs once more, alone, when that is few, or the host took a tenth of the processors'
# time or more. Prints the tests that were run twice with both results, those that were skipped
# with their reasons, the slowest and, as the last line, the closing line; all are kept in
# BUILD/tests.summary. Fails when a test failed (twice, if it was run twice) or a sanitizer
# reported.
run_tests() { # BUILD [ARGUMENTS OF CTEST]
  local build=$1 results=$1/tests.results again=$1/tests_again.results reports=$1/reports
  local summary=$1/tests.summary
  local status=0 worked stolen taken failed flaky=0
  shift
  rm -f "$summary" "$results" "$again" "$reports"/*
  read -r worked stolen < <(worked_and_stolen)
  run_ctest "$build" "$results" -j $((2 * $(nproc))) "$@" || status=$?
  taken=$(stolen_percent "$worked" "$stolen")
  failed=$(tests_that failed "$results" | wc -l)
  : > "$summary"
  if [[ $failed -gt 0 && ($failed -le $few_failures || $taken -ge 10) ]]; then
    echo "$failed failed, and the host took $taken % of the processors' time: again, alone"
    status=0
    run_ctest "$build" "$again" --rerun-failed "$@" || status=$?
    report_second_runs "$results" "$again" > "$summary"
    failed=$(grep -c '^failed twice: ' "$summary" || true)
    flaky=$(grep -c '^flaky: ' "$summary" || true)
  fi
  if [[ -d $reports && -n $(ls "$reports") ]]; then
    cat "$reports"/*
    status=1
  fi
  {
    report_skipped "$results"
    report_slowest "$results"
    closing_line "$results" "$failed" "$flaky" "$reports"
  } >> "$summary"
  cat "$summary"
  return "$status"
}

# Keeps the results, as results_in prints them. test_path: the PATH of the tests, if it is
# another than this.
run_ctest() { # BUILD RESULTS [ARGUMENTS OF CTEST]
  local status=0 log=$1/tests.log outputs=$1/Testing/Temporary/LastTest.log
  rm -f "$outputs"
  PATH=${test_path:-$PATH} ctest --test-dir "$1" --timeout 300 --output-on-failure \
    --no-label-summary --no-tests=error "${@:3}" 2>&1 | tee "$log" || status=$?
  [[ -e $outputs ]] || outputs=/dev/null
  results_in "$log" "$outputs" > "$2"
  return "$status"
}

# Runs the command, which is ended when the script has taken that many seconds, and says then
# that this part of the check was left out; its code is 124 then, else the command's own.
run_until() { # SECONDS WHAT COMMAND...
  local until=$1 what=$2 code=124
  shift 2
  if [[ $SECONDS -lt $until ]]; then
    code=0
    timeout --kill-after=20 $((until - SECONDS)) "$@" || code=$?
    [[ $code -ne 137 ]] || code=124
  fi
  [[ $code -ne 124 ]] || echo "$what was left out after $((SECONDS / 60)) minutes: $*"
  return "$code"
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

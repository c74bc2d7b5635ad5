# shellcheck shell=bash
# Runs ctest and reports its results. Sourced by tests/run, tests/sanitizers and .ci/run.

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

# Prints the closing line. The reports of sanitizers count as one test, because a process
# that a test starts and kills can write one without a test that fails.
closing_line() { # LOG FAILED_COUNT FOLDER_OF_SANITIZER_REPORTS
  local passed skipped failed=$2
  skipped=$(tests_that skipped "$1" | wc -l)
  passed=$(($(tests_that passed "$1" | wc -l) + $(tests_that failed "$1" | wc -l) - failed))
  if [[ -d $3 ]]; then
    if [[ -z $(ls "$3") ]]; then passed=$((passed + 1)); else failed=$((failed + 1)); fi
  fi
  echo "$passed passed, $failed failed, $skipped skipped"
}

# A test in real time needs a processor. More failures than this have another reason than
# the tests beside it, unless the host took a tenth of the processors' time.
few_failures=5

# Runs ctest, one test more at a time than there are processors, for the longest mostly wait
# for a machine in real time, and what failed for want of a processor, perhaps, once more,
# alone. Prints the tests that were run twice with both results and, as the last line, the
# closing line; both are kept in BUILD/tests.summary. Fails when a test failed (twice, if it
# was run twice) or a sanitizer reported.
run_tests() { # BUILD [ARGUMENTS OF CTEST]
  local build=$1 log=$1/tests.log again=$1/tests_again.log reports=$1/reports
  local status=0 worked stolen taken failed
  shift
  rm -f "$build/tests.summary" "$again" "$reports"/*
  read -r worked stolen < <(worked_and_stolen)
  run_ctest "$build" -j $(($(nproc) + 1)) "$@" 2>&1 | tee "$log" || status=$?
  taken=$(stolen_percent "$worked" "$stolen")
  failed=$(tests_that failed "$log" | wc -l)
  if [[ $failed -gt 0 && ($failed -le $few_failures || $taken -ge 10) ]]; then
    echo "$failed failed, and the host took $taken % of the processors' time: again, alone"
    status=0
    run_ctest "$build" --rerun-failed "$@" 2>&1 | tee "$again" || status=$?
    report_second_runs "$log" "$again" > "$build/tests.summary"
    failed=$(grep -c '^failed twice: ' "$build/tests.summary" || true)
  fi
  if [[ -d $reports && -n $(ls "$reports") ]]; then
    cat "$reports"/*
    status=1
  fi
  closing_line "$log" "$failed" "$reports" >> "$build/tests.summary"
  cat "$build/tests.summary"
  return "$status"
}

run_ctest() { # BUILD [ARGUMENTS OF CTEST]
  ctest --test-dir "$1" --timeout 300 --output-on-failure --no-label-summary \
    --no-tests=error "${@:2}"
}

# Prints what run_tests kept of the given build directories, each line with its directory's
# name, and one closing line with the sums. Fails when one of them has no results.
sum_up() { # BUILD...
  local build line passed=0 failed=0 skipped=0 status=0
  for build in "$@"; do
    if [[ ! -e $build/tests.summary ]]; then
      echo "${build##*/}: no results"
      status=1
      continue
    fi
    while read -r line; do
      echo "${build##*/}: $line"
      [[ $line =~ ^([0-9]+)\ passed,\ ([0-9]+)\ failed,\ ([0-9]+)\ skipped$ ]] || continue
      passed=$((passed + BASH_REMATCH[1]))
      failed=$((failed + BASH_REMATCH[2]))
      skipped=$((skipped + BASH_REMATCH[3]))
    done < "$build/tests.summary"
  done
  echo "$passed passed, $failed failed, $skipped skipped"
  return "$status"
}

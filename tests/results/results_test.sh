#!/usr/bin/env bash
# What run_tests and sum_up print, with a ctest and a host that are played.
#   tests/results/results_test.sh CASE
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/results.sh"
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT

# A line for each test "NAME=RESULT", as ctest prints it; fails when one has failed.
ctest_log() {
  local number=0 each status=0
  for each in "$@"; do
    number=$((number + 1))
    case ${each#*=} in
      passed) echo " $number/$# Test  #$number: ${each%=*} .......   Passed    0.02 sec" ;;
      *) echo "$number/$# Test #$number: ${each%=*} ...***${each#*=}   0.30 sec" ;;
    esac
    [[ ${each#*=} == @(passed|Skipped|"Not Run (Disabled)") ]] || status=8
  done
  return "$status"
}
# What ctest gives at first, and for what failed.
first=() second=()
ctest() {
  if [[ " $* " == *" --rerun-failed "* ]]; then
    echo "${second[*]}" >> "$build/run_again"
    ctest_log "${second[@]}"
  else
    ctest_log "${first[@]}"
  fi
}
# Between two calls 1000 jiffies are worked and host_took are taken.
host_took=0
worked_and_stolen() {
  if [[ -e $build/began ]]; then echo "1500 $((70 + host_took))"; else echo "500 70"; fi
  touch "$build/began"
}

status=0
run() {
  status=0
  : > "$build/run_again"
  run_tests "$build" > "$build/output" 2>&1 || status=$?
}
expect() { # WHAT ACTUAL EXPECTED
  [[ $2 == "$3" ]] && return
  printf '%s is\n%s\nand not\n%s\nThe whole output:\n' "$1" "$2" "$3"
  cat "$build/output"
  exit 1
}
expect_end() { # LINES
  expect "the end of the output" "$(tail -n "$(wc -l <<< "$1")" "$build/output")" "$1"
}
expect_one_run() { expect "what was run again" "$(cat "$build/run_again")" ""; }
expect_status() { expect "the status" "$status" "$1"; }

ManyFailuresWithoutStolenTimeAreNotRunAgain() {
  first=(A.B=passed C.1=Failed C.2=Failed C.3=Failed C.4=Timeout C.5=Failed C.6=Failed)
  second=(C.1=passed C.2=passed C.3=passed C.4=passed C.5=passed C.6=passed)
  host_took=99  # of 1099: 9 %
  run
  expect_one_run
  expect "what is kept" "$(cat "$build/tests.summary")" "1 passed, 6 failed, 0 skipped"
  expect_end "1 passed, 6 failed, 0 skipped"
  expect_status 8
}
AFewFailuresAreRunAgain() {
  first=(A.B=passed C.1=Failed C.2=Failed)
  second=(C.1=passed C.2=Failed)
  host_took=0
  run
  expect_end "flaky: C.1 failed, then passed alone
failed twice: C.2 failed, then failed alone
2 tests were run again: 1 flaky, 1 failed twice
2 passed, 1 failed, 0 skipped"
  expect_status 8
}
FlakyTestIsListedBesideTheClosingLine() {
  first=(A.B=passed "Each/C.D/a b=Failed" E.F=Failed G.H=Skipped)
  second=("Each/C.D/a b=passed" E.F=passed)
  host_took=250  # of 1250: 20 %
  run
  expect_end "flaky: Each/C.D/a b failed, then passed alone
flaky: E.F failed, then passed alone
2 tests were run again: 2 flaky, 0 failed twice
3 passed, 0 failed, 1 skipped"
  expect_status 0
}
TestThatFailsTwiceFails() {
  first=(A.B=passed C.D=Failed E.F=Timeout)
  second=(C.D=Failed E.F=passed)
  host_took=9000
  run
  expect_end "failed twice: C.D failed, then failed alone
flaky: E.F failed, then passed alone
2 tests were run again: 1 flaky, 1 failed twice
2 passed, 1 failed, 0 skipped"
  expect_status 8
}
AllPassedIsTheClosingLineAlone() {
  first=(A.B=passed C.D=Skipped "E.F=Not Run (Disabled)")
  host_took=9000
  run
  expect_one_run
  expect "what is kept" "$(cat "$build/tests.summary")" "1 passed, 0 failed, 2 skipped"
  expect_end "1 passed, 0 failed, 2 skipped"
  expect_status 0
}
CrashesAndTimeoutsAreFailures() {
  first=("A.B=Exception: SegFault" C.D=Timeout "E.F=Not Run" G.H=passed)
  second=("A.B=Exception: SegFault" C.D=Timeout "E.F=Not Run")
  run
  expect_end "1 passed, 3 failed, 0 skipped"
  expect_status 8
}
ReportOfASanitizerFails() {
  first=(A.B=passed)
  mkdir "$build/reports"
  run
  expect_end "2 passed, 0 failed, 0 skipped"
  expect_status 0
  ctest() {  # a process that a test has started reports; the test passes
    echo "WARNING: ThreadSanitizer: data race" > "$build/reports/report.17"
    ctest_log "${first[@]}"
  }
  run
  expect_end "WARNING: ThreadSanitizer: data race
1 passed, 1 failed, 0 skipped"
  expect_status 1
}
NoTestsFail() {
  ctest() { echo "No tests were found!!!"; return 8; }
  host_took=9000
  run
  expect_end "0 passed, 0 failed, 0 skipped"
  expect_status 8
}
SumOfBuilds() {
  mkdir "$build/release" "$build/asan"
  printf '%s\n' "flaky: A.B failed, then passed alone" "7 passed, 1 failed, 2 skipped" \
    > "$build/release/tests.summary"
  echo "20 passed, 3 failed, 0 skipped" > "$build/asan/tests.summary"
  sum_up "$build/release" "$build/asan" > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" "release: flaky: A.B failed, then passed alone
release: 7 passed, 1 failed, 2 skipped
asan: 20 passed, 3 failed, 0 skipped
27 passed, 4 failed, 2 skipped"
  expect_status 0
}
BuildWithoutResultsFails() {
  sum_up "$build/tsan" > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" "tsan: no results
0 passed, 0 failed, 0 skipped"
  expect_status 1
}

"${1:?which case}"

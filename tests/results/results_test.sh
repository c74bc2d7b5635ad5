#!/usr/bin/env bash
# What run_tests and sum_up print, with a ctest and a host that are played.
#   tests/results/results_test.sh CASE
set -euo pipefail
source "$(dirname "${BASH_SOURCE[0]}")/results.sh"
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT

# What each test prints, and how long it takes; what is not here prints nothing in 0.02 s.
declare -A prints=() takes=()

# A line for each test "NAME=RESULT", as ctest prints it; fails when one has failed. Keeps the
# outputs where ctest keeps them.
ctest_log() {
  local number=0 each name status=0 outputs=$build/Testing/Temporary/LastTest.log
  mkdir -p "${outputs%/*}"
  echo "Start testing: Nov 26 12:00 UTC" > "$outputs"
  for each in "$@"; do
    number=$((number + 1))
    name=${each%=*}
    case ${each#*=} in
      passed) echo " $number/$# Test  #$number: $name .......   Passed    ${takes[$name]:-0.02} sec" ;;
      killed) echo "$number/$# Test #$number: $name ...Subprocess killed***Exception:   0.02 sec" ;;
      *) echo "$number/$# Test #$number: $name ...***${each#*=}   ${takes[$name]:-0.02} sec" ;;
    esac
    printf '%s\n' "$number/$# Testing: $name" "Command: \"/a/test\"" "Output:" "-----" \
      "${prints[$name]:-}" "<end of output>" >> "$outputs"
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
  # As in tests/run, a pipe that fails ends the function: not so as the left side of "||".
  set +e
  (set -e; run_tests "$build") > "$build/output" 2>&1
  status=$?
  set -e
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
expect_lines() { # LINES, one below the other, anywhere in the output
  [[ $(cat "$build/output") == *"$1"* ]] && return
  printf 'the output has not\n%s\nThe whole output:\n' "$1"
  cat "$build/output"
  exit 1
}
expect_one_run() { expect "what was run again" "$(cat "$build/run_again")" ""; }
expect_status() { expect "the status" "$status" "$1"; }

ManyFailuresWithoutStolenTimeAreNotRunAgain() {
  first=(A.B=passed)
  second=()
  local i
  for i in {1..26}; do
    first+=("C.$i=Failed")
    second+=("C.$i=passed")
  done
  host_took=99  # of 1099: 9 %
  run
  expect_one_run
  expect_end "1 passed, 26 failed, 0 skipped"
  expect_status 8
}
AFewFailuresAreRunAgain() {
  first=(A.B=passed C.1=Failed C.2=Failed)
  second=(C.1=passed C.2=Failed)
  host_took=0
  run
  expect_lines "flaky: C.1 failed, then passed alone
failed twice: C.2 failed, then failed alone
2 tests were run again: 1 flaky, 1 failed twice"
  expect_end "1 passed, 1 failed, 0 skipped, 1 flaky"
  expect_status 8
}
FlakyTestIsListedAndCountedApart() {
  first=(A.B=passed "Each/C.D/a b=Failed" E.F=Failed G.H=Skipped)
  second=("Each/C.D/a b=passed" E.F=passed)
  host_took=250  # of 1250: 20 %
  run
  expect_lines "flaky: Each/C.D/a b failed, then passed alone
flaky: E.F failed, then passed alone
2 tests were run again: 2 flaky, 0 failed twice"
  expect_end "1 passed, 0 failed, 1 skipped, 2 flaky"
  expect_status 0
}
TestThatFailsTwiceFails() {
  first=(A.B=passed C.D=Failed E.F=Timeout)
  second=(C.D=Failed E.F=passed)
  host_took=9000
  run
  expect_lines "failed twice: C.D failed, then failed alone
flaky: E.F failed, then passed alone
2 tests were run again: 1 flaky, 1 failed twice"
  expect_end "1 passed, 1 failed, 0 skipped, 1 flaky"
  expect_status 8
}
AllPassedAreCounted() {
  first=(A.B=passed C.D=passed)
  host_took=9000
  run
  expect_one_run
  expect "what is kept" "$(cat "$build/tests.summary")" "slowest: A.B 0.02 s, C.D 0.02 s
2 passed, 0 failed, 0 skipped"
  expect_end "2 passed, 0 failed, 0 skipped"
  expect_status 0
}
SkippedTestsAreCountedByReason() {
  first=(A.B=passed C.1=Skipped C.2=Skipped C.3=Skipped "C.4=Not Run (Disabled)" C.5=Skipped)
  prints=([A.B]="a_test.cc:7: Skipped
this one passed"
    [C.1]="[ RUN      ] C.1
a_test.cc:17: Skipped
no rs274: install it

[  SKIPPED ] C.1 (0 ms)" [C.2]="a_test.cc:19: Skipped
as root" [C.3]="b_test.cc:1: Skipped
no rs274: install it" [C.5]="a script says it at its end")
  run
  expect_lines "skipped: 2 because: no rs274: install it
skipped: 1 because: a script says it at its end
skipped: 1 because: as root
skipped: 1 because: it gives no reason"
  expect_end "1 passed, 0 failed, 5 skipped"
  expect_status 0
}
TheTenSlowestAreNamed() {
  local i
  first=(Quick.A=passed "Each/C.D/a b=Failed")
  takes=(["Each/C.D/a b"]=100.25)
  for i in 1 2 3 4 5 6 7 8 9 10; do
    first+=("A.$i=passed")
    takes[A.$i]=$i.50
  done
  run
  expect_end "slowest: Each/C.D/a b 100.25 s, A.10 10.50 s, A.9 9.50 s, A.8 8.50 s, A.7 7.50 s, \
A.6 6.50 s, A.5 5.50 s, A.4 4.50 s, A.3 3.50 s, A.2 2.50 s
11 passed, 1 failed, 0 skipped"
}
ThousandsOfTestsHaveResults() {
  local i
  first=()
  for i in {1..2000}; do first+=("Each/ATestWithALongName.ThatFillsThePipeBetweenTwoPrograms/$i=passed"); done
  run
  expect "the closing line" "$(tail -n 1 "$build/output")" "2000 passed, 0 failed, 0 skipped"
  expect_status 0
}
CrashesAndTimeoutsAreFailures() {
  first=("A.B=Exception: SegFault" C.D=Timeout "E.F=Not Run" G.H=passed)
  second=("A.B=Exception: SegFault" C.D=Timeout "E.F=Not Run")
  run
  expect_end "1 passed, 3 failed, 0 skipped"
  expect_status 8
}
KilledTestThatPassesAloneIsFlaky() {
  first=(A.B=killed C.D=passed)
  second=(A.B=passed)
  run
  expect_lines "flaky: A.B failed, then passed alone"
  expect_end "1 passed, 0 failed, 0 skipped, 1 flaky"
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
  expect_lines "WARNING: ThreadSanitizer: data race"
  expect_end "1 passed, 1 failed, 0 skipped"
  expect_status 1
}
# A line of GoogleTest for each case "NAME=RESULT" of a program; a case without an end is at
# work when the program ends.
cases() {
  local each name
  echo "[==========] Running $# tests from 1 test suite."
  for each in "$@"; do
    name=${each%=*}
    echo "[ RUN      ] $name"
    case ${each#*=} in
      passed) echo "it counts to 3[       OK ] $name (1500 ms)" ;;
      skipped) printf '%s\n' "a_test.cc:1: Skipped" "no network" "" "[  SKIPPED ] $name (0 ms)" ;;
      failed) echo "[  FAILED  ] $name, where GetParam() = 7 (20 ms)" ;;
      crashed) return ;;
      unheard) ;;
    esac
  done
  echo "[==========] $# tests from 1 test suite ran. (3 ms total)"
}
CasesOfAProgramAreResults() {
  first=("All of a_test=Failed" "All of b_test=passed" C.D=passed)
  second=("All of a_test=Failed")
  prints=(["All of a_test"]="$(cases A.1=passed Each/A.2/0=failed A.3=skipped A.4=failed)"
    ["All of b_test"]="$(cases B.1=passed B.2=unheard B.3=passed)")
  ctest() {
    if [[ " $* " != *" --rerun-failed "* ]]; then ctest_log "${first[@]}"; return; fi
    prints["All of a_test"]=$(cases A.1=passed Each/A.2/0=passed A.3=skipped A.4=failed)
    ctest_log "${second[@]}"
  }
  run
  expect_lines "flaky: Each/A.2/0 failed, then passed alone
failed twice: A.4 failed, then failed alone
2 tests were run again: 1 flaky, 1 failed twice
skipped: 1 because: no network
slowest: A.1 1.50 s, B.1 1.50 s, B.3 1.50 s, Each/A.2/0 0.02 s, A.4 0.02 s, C.D 0.02 s, B.2 0.00 s"
  expect_end "5 passed, 1 failed, 1 skipped, 1 flaky"
  expect_status 8
}
CaseAtWorkWhenAProgramCrashesFails() {
  first=("All of a_test=Exception: SegFault")
  second=("All of a_test=passed")
  prints=(["All of a_test"]="$(cases A.1=passed A.2=crashed A.3=passed)")
  ctest() {
    if [[ " $* " != *" --rerun-failed "* ]]; then ctest_log "${first[@]}"; return; fi
    prints["All of a_test"]=$(cases A.1=passed A.2=passed A.3=passed)
    ctest_log "${second[@]}"
  }
  run
  expect_lines "flaky: A.2 failed, then passed alone
flaky: All of a_test failed, then passed alone"
  expect_end "1 passed, 0 failed, 0 skipped, 2 flaky"
  expect_status 0
}
ProgramThatFailsBehindItsCasesFails() {
  first=("All of a_test=Timeout" C.D=passed)
  second=("All of a_test=Timeout")
  prints=(["All of a_test"]="$(cases A.1=passed A.2=passed)")
  run
  expect_lines "failed twice: All of a_test failed, then failed alone"
  expect_end "3 passed, 1 failed, 0 skipped"
  expect_status 8
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
  printf '%s\n' "flaky: A.B failed, then passed alone" \
    "7 passed, 1 failed, 2 skipped, 1 flaky" \
    > "$build/release/tests.summary"
  echo "20 passed, 3 failed, 0 skipped" > "$build/asan/tests.summary"
  sum_up "$build/release" "$build/asan" > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" "release: flaky: A.B failed, then passed alone
release: 7 passed, 1 failed, 2 skipped, 1 flaky
asan: 20 passed, 3 failed, 0 skipped
27 passed, 4 failed, 2 skipped, 1 flaky"
  expect_status 0
}
BuildWithoutResultsFails() {
  sum_up "$build/tsan" > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" "tsan: no results
0 passed, 0 failed, 0 skipped"
  expect_status 1
}

PartThatLastsTooLongIsLeftOut() {
  SECONDS=4499
  run_until 4500 "The part" sleep 30 > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" "The part was left out after 75 minutes: sleep 30"
  expect_status 124
  run_until 4500 "The next part" touch "$build/ran" > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" \
    "The next part was left out after 75 minutes: touch $build/ran"
  [[ ! -e $build/ran ]] || expect "what ran" touch nothing
  expect_status 124
}
PartThatEndsInTimeHasItsOwnCode() {
  SECONDS=100
  run_until 200 "The part" sh -c 'echo it ran; exit 3' > "$build/output" || status=$?
  expect "the output" "$(cat "$build/output")" "it ran"
  expect_status 3
}

"${1:?which case}"

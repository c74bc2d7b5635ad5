#!/usr/bin/env bash
# large_pages_test.sh: what tests/large_pages.sh sets, with a file in place of the kernel's.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
source tests/large_pages.sh
large_pages_setting=$(mktemp)
trap 'rm -f "$large_pages_setting"' EXIT
expect() { # WHAT ACTUAL EXPECTED
  [[ $2 == "$3" ]] || { echo "$1 is '$2' and not '$3'"; exit 1; }
}
echo 'always [madvise] never' > "$large_pages_setting"
expect "the setting at the command" "$(with_large_pages cat "$large_pages_setting")" always
expect "the setting behind it" "$(cat "$large_pages_setting")" madvise
status=0
echo 'always madvise [never]' > "$large_pages_setting"
with_large_pages false || status=$?
expect "the status of a command that fails" "$status" 1
expect "the setting behind a command that fails" "$(cat "$large_pages_setting")" never
rm "$large_pages_setting"
expect "what a computer without the setting runs" "$(with_large_pages echo it)" it
[[ ! -e $large_pages_setting ]] || { echo "it makes the setting"; exit 1; }

# shellcheck shell=bash
# Sourced by tests/run.

# Runs a command while this computer gives out memory in large pages, where that may be set.
# A compilation touches 100 000 pages of 4 KiB for the first time; where a hypervisor keeps the
# tables of pages, they take a fifth of its time. What was set before is set again, whatever
# becomes of the command; the tests judge memory by what is set on this computer.
with_large_pages() { # COMMAND...
  local setting=${large_pages_setting:-/sys/kernel/mm/transparent_hugepage/enabled} before
  if [[ ! -w $setting ]]; then
    "$@"
    return
  fi
  before=$(sed -E 's/.*\[(.*)\].*/\1/' "$setting")
  (
    trap 'echo "$before" > "$setting"' EXIT
    echo always > "$setting"
    "$@"
  )
}

#!/usr/bin/env bash
# Of the programs in FOLDER, intaglio-mesh-reader alone is linked with Assimp.
#   tests/loads_assimp.sh FOLDER
set -euo pipefail
found=$(cd "${1:?a folder}" && grep --files-with-matches 'libassimp\.so' -- * | xargs)
[[ $found == intaglio-mesh-reader ]] || {
  echo "linked with Assimp: ${found:-none}; expected: intaglio-mesh-reader" >&2
  exit 1
}

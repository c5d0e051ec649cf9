#!/usr/bin/env bash
# Bundles the pages once more and compares them with those that are kept: check_page.sh NEW_FOLDER. Exits with 77 and says why
# where there is no node or npm, or npm cannot reach its packages.
set -euo pipefail
new=$(realpath -m "$1")
cd "$(dirname "$(readlink -f "$0")")"
for program in node npm; do command -v $program >/dev/null || { echo "skipped: there is no $program"; exit 77; }; done
if [[ ! node_modules/.package-lock.json -nt package-lock.json ]]; then
  npm ci --no-audit --no-fund --ignore-scripts --loglevel=error || { echo "skipped: npm cannot install the page's packages"; exit 77; }
  touch node_modules/.package-lock.json  # npm leaves it as it was where nothing had to be done
fi
node build.mjs "$new"
for page in page.html live.html packages.js; do
  cmp "$new/$page" "dist/$page" || { echo "web/dist/$page is not what web/src gives: run ./dev page and commit it"; exit 1; }
done

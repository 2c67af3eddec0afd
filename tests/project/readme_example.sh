#!/usr/bin/env bash
# Runs the blocks of README.md that stand below a line `<!-- test -->`, in order, against the built program:
#   readme_example.sh PROGRAM README
set -euo pipefail
program="$(realpath "$1")"
readme="$(realpath "$2")"

work="$(mktemp -d)"
server=
clean_up() {
  [ -z "$server" ] || { kill -TERM "$server" 2> /dev/null || true; wait "$server" 2> /dev/null || true; }
  rm -rf "$work"
}
trap clean_up EXIT
cd "$work"

: > serve.log  # the server may be slower to make it than the loop below is to look
"$program" serve --host 127.0.0.1 --port 0 > serve.log 2>&1 < /dev/null &
server=$!
address=
for _ in {1..200}; do
  address="$(sed -n 's|^serving on \(http://[^/]*\)/.*|\1|p' serve.log)"
  if [ -n "$address" ] && curl -s --fail -o /dev/null "$address/readyz"; then break; fi
  kill -0 "$server" 2> /dev/null || { cat serve.log; exit 1; }
  sleep 0.1
done
[ -n "$address" ] || { cat serve.log; exit 1; }

awk '/^<!-- test -->$/ { marked = 1; next }
     marked && /^```sh$/ { inside = 1; marked = 0; blocks++; next }
     inside && /^```$/ { inside = 0; next }
     inside { print }
     END { if (blocks < 3) { print "echo README has lost its tested blocks; exit 1" } }' "$readme" |
  sed "s|http://127.0.0.1:8080|$address|g" > blocks.sh
mkdir bin
ln -s "$program" bin/morphograph
PATH="$work/bin:$PATH" bash -euxo pipefail blocks.sh

head -1 walk.bvh | grep -q '^HIERARCHY'
grep -q '"bvh"' answer.json
grep -q '"foot_skate_cm_s"' walk.report.json

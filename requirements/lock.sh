#!/bin/sh
# Makes the lock files anew from the .in files; pins stay where they satisfy them, unless with --upgrade.
# Needs uv (pip install uv). The environment of a run comes first: the other groups have the versions of its packages.
set -eu
cd "$(dirname -- "$0")/.."
lock() {
    group=$1
    shift
    uv pip compile --quiet --universal --python-version 3.11 --generate-hashes --no-header --no-emit-index-url \
        --output-file "requirements/$group.lock" "$@" "requirements/$group.in" >/dev/null
}
lock run "$@"
for group in plots bench study gym docs test peers; do
    lock "$group" --constraints requirements/run.lock "$@"
done
lock interfaces "$@" # an environment of its own

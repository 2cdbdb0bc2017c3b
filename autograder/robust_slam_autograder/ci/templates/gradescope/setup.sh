#!/usr/bin/env bash
# Gradescope runs this once, as root, when it builds the container's image.
set -euo pipefail
umask 022 # student code runs as a user of its own, and has to read what is installed here
source="$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)"
here="$(dirname "$source")"

find_python() {
    for python in python3 python3.13 python3.12 python3.11; do
        if "$python" -c 'import ensurepip, sys, venv; sys.exit(sys.version_info < (3, 11))' \
            2>/dev/null; then
            return 0
        fi
    done
    return 1
}

if ! find_python; then
    export DEBIAN_FRONTEND=noninteractive # a package that asks would wait for ever
    apt-get update
    apt-get install -y python3.12 python3.12-venv || apt-get install -y python3.11 python3.11-venv
    find_python || { echo "Python 3.11 or newer is needed: choose a newer image."; exit 1; }
fi
"$python" -m venv "$here/python"
"$here/python/bin/python" -m pip install --constraint "$source/constraints.txt" \
    @INSTALL@
chmod -R go-rwx "$source" # hidden tests: a second wall, beside the sandbox
# Only to be read in the build's log: what counts is whether one works when a submission comes.
"$here/python/bin/autograder" doctor || echo "No sandbox works while the image is being built."

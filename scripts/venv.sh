#!/bin/sh
# Make .venv with vrlf (editable), all extras but cvvdp and the development tools in it.
#
# .venv/.vrlf-setup keeps what it was made from. As long as that is still so,
# the script changes nothing and needs no network. A changed pyproject.toml or
# constraints.txt installs on top; another Python or another folder makes .venv
# anew, because the scripts in it name both.
set -eu

stamp=.venv/.vrlf-setup
venv_python=.venv/bin/python

say() { echo "set-up: $*" >&2; }

# Line 1: the Python of .venv and where it stands. Line 2: what it was asked to hold.
# Prints nothing if .venv cannot be used.
fingerprint() {
    "$venv_python" - 2>/dev/null <<'PYTHON'
import hashlib, os, sys

import pip  # a .venv that was left half-made has none

assert sys.version_info >= (3, 11)
asked = hashlib.sha256()
for name in ("pyproject.toml", "constraints.txt"):
    with open(name, "rb") as file:
        asked.update(file.read() + b"\0")
print(sys.version.split()[0], sys._base_executable, os.getcwd())
print(asked.hexdigest())
PYTHON
}

first_line() { printf '%s\n' "$1" | sed -n 1p; }

# PYTHON=... asks for one interpreter; a .venv of another one does not do.
is_of_the_python_asked_for() {
    [ -z "${PYTHON:-}" ] || [ "$("$PYTHON" -VV 2>&1)" = "$("$venv_python" -VV 2>&1)" ]
}

now=$(fingerprint || true)
made_from=$(cat "$stamp" 2>/dev/null || true)
is_of_the_python_asked_for || now=""

[ -n "$now" ] && [ "$now" = "$made_from" ] && exit 0

rm -f "$stamp"
if [ -z "$now" ] || [ "$(first_line "$now")" != "$(first_line "${made_from:-$now}")" ]; then
    python=$(sh scripts/find-python.sh)
    say "making .venv with $python"
    "$python" -m venv --clear .venv || { say "$python cannot make .venv (see above)"; exit 1; }
fi

say "installing vrlf and what it needs into .venv (about a minute, once)"
"$venv_python" -m pip install --quiet -c constraints.txt -e '.[window,plots,flip,design,serve,sweep,dev]' ||
    { say "pip could not install vrlf (see above); run make again when that is mended"; exit 1; }

# Written last: an interrupted set-up starts again.
fingerprint >"$stamp"

#!/bin/sh
# Print the path of a Python of at least 3.11, or one line that says what is wanted.
#
# PYTHON, if set, is the only one tried. A candidate counts only if it runs:
# version managers leave names on the PATH that answer "command not found".
set -eu

if [ -n "${PYTHON:-}" ]; then
    set -- "$PYTHON"
else
    set -- python3 python3.13 python3.12 python3.11 python3.14
fi

# The base interpreter, so that an activated .venv is never built from itself.
probe='import sys
print("%d.%d.%d" % sys.version_info[:3], int(sys.version_info >= (3, 11)),
      getattr(sys, "_base_executable", sys.executable))'

found=""
for candidate; do
    answer=$("$candidate" -c "$probe" 2>/dev/null) || continue
    version=${answer%% *}
    path=${answer#* * }
    case $answer in
        *" 1 "*) printf '%s\n' "$path" && exit 0 ;;
    esac
    found="${found:+$found, }Python $version at $path"
done

echo "set-up: found ${found:-no ${PYTHON:-Python}}, wanted Python 3.11 or newer; install one" \
    "(Debian 12, Ubuntu 24.04 or later: apt-get install python3 python3-venv; Ubuntu 22.04:" \
    "apt-get install python3.11 python3.11-venv) or name one: make test PYTHON=/path/to/python3" >&2
exit 1

#!/bin/sh
# Add the extra cvvdp to .venv: PyTorch, which not every checkout wants for one metric.
set -eu

venv_python=.venv/bin/python

"$venv_python" -c 'from importlib.metadata import version; version("cvvdp")' 2>/dev/null && exit 0

echo "set-up: installing the extra cvvdp into .venv (PyTorch: 0.2 to 5 GB, once)" >&2
"$venv_python" -m pip install --quiet -c constraints.txt -e '.[cvvdp]' ||
    { echo "set-up: pip could not install cvvdp (see above)" >&2; exit 1; }

"""``vrlf``: the group of commands, and how every error becomes one line."""

from __future__ import annotations

import os
import sys
from typing import Any

import click

from vrlf import __version__
from vrlf.app.benching import bench
from vrlf.app.demo import demo
from vrlf.app.facts import doctor, inspect, rigs
from vrlf.app.pictures import chart, perceive, prefilter
from vrlf.errors import VrlfError

_DEBUG = "VRLF_DEBUG"
_INTERRUPTED = 130


@click.group(context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100})
@click.version_option(__version__, prog_name="vrlf")
def vrlf() -> None:
    """Correct a person's vision inside a VR headset by computation alone.

    A rig (-r) says what panel, headset, array and eyes there are: the name of a shipped one
    (see 'vrlf rigs') or a file. Results go to standard output, messages to standard error.
    """


for _command in (demo, prefilter, perceive, inspect, doctor, rigs, chart, bench):
    vrlf.add_command(_command)


def main(arguments: list[str] | None = None) -> None:
    """Run a command and leave with its exit status: 0 done, 2 wrong input, 1 anything else."""
    sys.exit(run(arguments))


def run(arguments: list[str] | None = None) -> int:
    """Run a command; the exit status."""
    try:
        result: Any = vrlf.main(args=arguments, prog_name="vrlf", standalone_mode=False)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except VrlfError as error:
        return _fail(str(error), error.exit_code)
    except click.UsageError as error:
        where = error.ctx.command_path if error.ctx is not None else "vrlf"
        return _fail(f"{_one_line(error.format_message())} (see '{where} --help')", 2)
    except click.ClickException as error:
        return _fail(_one_line(error.format_message()), error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        return _fail("interrupted", _INTERRUPTED)
    except BrokenPipeError:
        # The reader of our output has left; keep Python from complaining at exit.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 1
    except Exception as error:
        if os.environ.get(_DEBUG):
            raise
        what = f"{type(error).__name__}: {_one_line(str(error))}"
        return _fail(f"unexpected {what} (set {_DEBUG}=1 for the details, and please report it)", 1)


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _fail(message: str, status: int) -> int:
    print(f"vrlf: {message}", file=sys.stderr)
    if status != 2:
        _drop_unwritable_output()
    return status


def _drop_unwritable_output() -> None:
    """After a failed write nothing may be left for Python's exit to fail on again."""
    try:
        sys.stdout.flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())

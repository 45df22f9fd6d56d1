"""``vrlf``: the group of commands, and how every error becomes one line."""

from __future__ import annotations

import contextlib
import os
import sys
from typing import Any

import click

from vrlf import __version__
from vrlf.app.benching import bench
from vrlf.app.comparing import compare
from vrlf.app.demo import demo
from vrlf.app.designing import design
from vrlf.app.evaluating import evaluate
from vrlf.app.eyes import eye
from vrlf.app.facts import doctor, inspect, rigs
from vrlf.app.lenslets import lenslet
from vrlf.app.masking import mask
from vrlf.app.options import say
from vrlf.app.pictures import chart, perceive, prefilter
from vrlf.app.previewing import preview
from vrlf.app.profiles import profile
from vrlf.app.rendering import render
from vrlf.app.reproducing import reproduce
from vrlf.app.serving import serve
from vrlf.app.sweeping import sweep
from vrlf.errors import VrlfError

_DEBUG = "VRLF_DEBUG"


@click.group(
    invoke_without_command=True,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="""
    \b
    To begin with:
      vrlf doctor                                          does this GPU serve?
      vrlf inspect --left "-5.00 / -1.25 x 170" --right "-4.50"
      vrlf demo -o demo-out                                the whole chain in pictures
      vrlf preview                                         the same live, by keyboard
    \b
    A picture of your own, through your own eyes:
      vrlf prefilter photo.jpg --both "-4.50" -o panel.png
      vrlf perceive panel.png --both "-4.50" -o seen.png
      vrlf evaluate photo.jpg --both "-4.50" -o report     all of it in numbers and a report

    'vrlf rigs --help' shows how a rig file is written, 'vrlf COMMAND --help' the options.
    Exit status: 0 done, 2 the input is wrong, 1 anything else.
    """,
)
@click.version_option(__version__, prog_name="vrlf")
@click.pass_context
def vrlf(context: click.Context) -> None:
    """Correct a person's vision inside a VR headset by computation alone.

    From a picture and a rig (panel, headset, array, both eyes), vrlf computes the image that
    the panel must show so that the eyes see the picture sharp without glasses, and what they
    then see.

    A rig (-r) is the name of a shipped one (see 'vrlf rigs') or a file. Results go to standard
    output, messages to standard error.
    """
    if context.invoked_subcommand is None:
        click.echo(context.get_help())


for _command in (
    *(demo, prefilter, perceive, evaluate, compare, preview, render, serve),
    *(inspect, eye, lenslet, design, mask, doctor, rigs, profile, chart, bench, sweep, reproduce),
):
    vrlf.add_command(_command)


def main(arguments: list[str] | None = None) -> None:
    """Run a command and leave with its exit status: 0 done, 2 wrong input, 1 anything else."""
    status = run(arguments)
    # A message that standard error never took must not change the status at Python's exit.
    _drop_unwritable_output()
    sys.exit(status)


def run(arguments: list[str] | None = None) -> int:
    """Run a command; the exit status."""
    try:
        if sys.stdout is None:
            return _fail("standard output: found it closed, wanted an open one", 1)
        result: Any = vrlf.main(args=arguments, prog_name="vrlf", standalone_mode=False)
        sys.stdout.flush()
        return result if isinstance(result, int) else 0
    except VrlfError as error:
        return _fail(str(error), error.exit_code)
    except click.UsageError as error:
        where = error.ctx.command_path if error.ctx is not None else "vrlf"
        return _fail(f"{_one_line(error.format_message()).rstrip('.')} (see '{where} --help')", 2)
    except click.ClickException as error:
        return _fail(_one_line(error.format_message()), error.exit_code)
    except (click.Abort, KeyboardInterrupt):
        return _fail("interrupted", 1)
    except BrokenPipeError:
        _drop_unwritable_output()  # the reader of our output has left, which is its right
        return 1
    except MemoryError:
        return _fail("memory: found too little, wanted more; a smaller panel needs less", 1)
    except Exception as error:
        if os.environ.get(_DEBUG):
            raise
        return _fail(_unexpected(error), 1)


def _unexpected(error: Exception) -> str:
    if isinstance(error, OSError) and error.filename is None and error.strerror:
        # All files are written by ``vrlf.files``, which says which; this is not one of them.
        return f"standard output: found '{error.strerror}', wanted room for the result"
    return (
        f"unexpected {type(error).__name__}: {_one_line(str(error))} "
        f"(set {_DEBUG}=1 for the details, and please report it)"
    )


def _one_line(text: str) -> str:
    return " ".join(text.split())


def _fail(message: str, status: int) -> int:
    say(f"vrlf: {message}")
    _drop_unwritable_output()
    return status


def _drop_unwritable_output() -> None:
    """After a failed write nothing may be left for Python's exit to fail on again."""
    for stream in (sys.stdout, sys.stderr):
        if stream is None:
            continue
        try:
            stream.flush()
        except OSError:
            with contextlib.suppress(OSError):
                os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())

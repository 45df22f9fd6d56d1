"""Options that several commands share."""

from __future__ import annotations

import contextlib
import json
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal, TypeVar

import click

from vrlf.model import DEFAULT_RIG, Rig, load_rig
from vrlf.optics.advice import wavefront_advice
from vrlf.optics.samples import MAX_POINTS
from vrlf.renderer import GpuRenderer, ReferenceRenderer, Renderer

Command = TypeVar("Command", bound=Callable[..., Any])
DeviceName = Literal["gpu", "reference"]


@dataclass(frozen=True)
class RigChoice:
    """What was said of the rig on the command line."""

    name: str
    overrides: tuple[str, ...]
    left: str | None
    right: str | None
    both: str | None

    def load(self) -> Rig:
        """The rig itself."""
        return load_rig(
            self.name, overrides=self.overrides, left=self.left, right=self.right, both=self.both
        )


def rig_options(command: Command) -> Command:
    """``-r``, ``--set``, ``--left``, ``--right`` and ``--both``; see ``rig_choice``."""
    chosen = click.option(
        "-r",
        "--rig",
        "rig_name",
        default=DEFAULT_RIG,
        show_default=True,
        metavar="RIG",
        help="A shipped rig's name (see 'vrlf rigs') or a .toml file.",
    )
    return chosen(_change_options(command))


def several_rig_options(command: Command) -> Command:
    """The same with any number of rigs, each changed alike; see ``rig_choices``."""
    chosen = click.option(
        "-r",
        "--rig",
        "rig_names",
        multiple=True,
        default=[DEFAULT_RIG],
        show_default=True,
        metavar="RIG",
        help="A shipped rig's name (see 'vrlf rigs') or a .toml file; can be given again.",
    )
    return chosen(_change_options(command))


def _change_options(command: Command) -> Command:
    for option in reversed(
        (
            click.option(
                "--set",
                "overrides",
                multiple=True,
                metavar="TABLE.KEY=VALUE",
                help="Change one key of the rig, e.g. left.pupil_mm=4. Can be given again, and "
                "wins over all else.",
            ),
            click.option(
                "--left",
                metavar="RX",
                help="The left eye's prescription as on paper, e.g. '-5.00 / -1.25 x 170'.",
            ),
            click.option("--right", metavar="RX", help="The right eye's."),
            click.option("--both", metavar="RX", help="One for both eyes, e.g. -4.5 or plano."),
        )
    ):
        command = option(command)
    return command


def rig_choice(options: dict[str, Any]) -> RigChoice:
    """Take the rig's options out of a command's keyword arguments."""
    return RigChoice(name=options.pop("rig_name"), **_changes(options))


def rig_choices(options: dict[str, Any]) -> list[RigChoice]:
    """Take several rigs' options out, each rig once."""
    names, changes = dict.fromkeys(options.pop("rig_names")), _changes(options)
    return [RigChoice(name=name, **changes) for name in names]


def _changes(options: dict[str, Any]) -> dict[str, Any]:
    taken = {name: options.pop(name) for name in ("left", "right", "both")}
    return {"overrides": tuple(options.pop("overrides")), **taken}


def whole_number(least: int, most: int) -> Callable[[str | int], int]:
    """What click turns an option's text into a number of a range with."""

    def convert(text: str | int) -> int:
        try:
            number = int(text)
        except ValueError:
            number = least - 1
        if not least <= number <= most:
            raise click.BadParameter(
                f"found {str(text)[:40]!r}, wanted a whole number from {least} to {most}"
            )
        return number

    return convert


def rays_option(default: int) -> Callable[[Command], Command]:
    """``--rays``."""
    return click.option(
        "--rays",
        type=whole_number(1, MAX_POINTS),
        default=default,
        show_default=True,
        metavar="N",
        help=f"Rays for each retinal pixel, at most {MAX_POINTS}: more are slower and less noisy.",
    )


device_option = click.option(
    "--device",
    type=click.Choice(["gpu", "reference"]),
    default="gpu",
    show_default=True,
    help="The GPU, or the slow float64 reference on the CPU, which needs none.",
)
json_option = click.option(
    "--json", "as_json", is_flag=True, help="Say the result as one JSON object instead of text."
)


@contextlib.contextmanager
def renderer_of(device: DeviceName) -> Iterator[Renderer]:
    """The renderer that was asked for; given back at the end."""
    if device == "reference":
        yield ReferenceRenderer()
        return
    with GpuRenderer() as renderer:
        yield renderer


def say_of_wavefronts(rig: Rig) -> None:
    """Whether the eyes' tables may mean something else than they say, before work is done."""
    for sentence in wavefront_advice(rig):
        say(f"take note: {sentence}")


def say(message: str) -> None:
    """A message or progress, to standard error; one that cannot be said is no reason to stop."""
    if sys.stderr is not None:  # print would take None for standard output
        with contextlib.suppress(OSError):
            print(message, file=sys.stderr, flush=True)


def put_json(value: dict[str, Any]) -> None:
    """One JSON object to standard output; strict JSON, so no NaN or infinity."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))

"""What a report is made of."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from vrlf.evaluation.metrics.model import Value


@dataclass(frozen=True)
class Map:
    """Where a perceived picture differs, in false colours.

    Attributes
    ----------
    title : str
        What it shows.
    png : bytes
    """

    title: str
    png: bytes


@dataclass(frozen=True)
class View:
    """What one eye perceives with one method.

    Attributes
    ----------
    method : str
    seen, panel : bytes
        The perceived picture and the panel image behind it, PNG.
    values : mapping
        By metric.
    maps : tuple of Map
    notes : tuple of str
        Why a value is missing.
    """

    method: str
    seen: bytes
    panel: bytes
    values: Mapping[str, Value]
    maps: tuple[Map, ...] = ()
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plot:
    """A plot that is drawn already.

    Attributes
    ----------
    title, words : str
        Its heading, and what it shows, for those who cannot see it.
    svg : bytes
    """

    title: str
    words: str
    svg: bytes


@dataclass(frozen=True)
class Eye:
    """One eye before one target.

    Attributes
    ----------
    side : str
        ``left`` or ``right``.
    paper : str
        Its prescription as on paper, its pupil, its blur.
    border_px : int
        How much at the edges is not judged.
    target : bytes
        What it should perceive, PNG.
    views : tuple of View
        By method.
    plots : tuple of Plot
        Of what has a number at each frequency.
    """

    side: str
    paper: str
    border_px: int
    target: bytes
    views: tuple[View, ...]
    plots: tuple[Plot, ...] = ()


@dataclass(frozen=True)
class Pair:
    """One source before one rig.

    Attributes
    ----------
    throughput : float
        Of the array.
    facts : str
        Panel, headset and array in a sentence.
    eyes : tuple of Eye
    """

    source: str
    rig: str
    throughput: float
    facts: str
    eyes: tuple[Eye, ...]


@dataclass(frozen=True)
class Report:
    """All of an evaluation.

    Attributes
    ----------
    pairs : tuple of Pair
    rays : int
        For each retinal pixel, of the judge.
    rig_texts : mapping of str to str
        Every rig as TOML, by name.
    versions : mapping of str to str
        Of everything that the numbers depend on.
    plots : tuple of Plot
    notes : tuple of str
        What the reader must know, such as a metric that could not be had.
    failures : tuple of str
        Cases that could not be computed, each with its reason.
    """

    pairs: tuple[Pair, ...]
    rays: int
    rig_texts: Mapping[str, str]
    versions: Mapping[str, str]
    plots: tuple[Plot, ...] = ()
    notes: tuple[str, ...] = ()
    failures: tuple[Mapping[str, str], ...] = field(default=())

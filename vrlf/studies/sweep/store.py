"""The folder of a sweep: rows as they come, and each exactly once in the end.

``sweep.json`` says what sweep it is. A row goes to ``journal.jsonl`` first; every so often the
journal's rows become a Parquet file of their own under ``parts/``, whole or not there. At the
end all of them, sorted by index, become ``results.parquet``. Jobs without a row are in
``failures.jsonl``. Whatever moment a run stops at, the next one finds each row in one of these
places at least, and takes it from one alone.
"""

from __future__ import annotations

import io
import json
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, Final, Self

from vrlf.errors import OutputError, OutputPathError, VrlfError
from vrlf.files import atomic_write_bytes, atomic_write_text, check_target, make_folder, shown
from vrlf.studies.sweep.journal import Journal
from vrlf.studies.sweep.plan import Job, Plan
from vrlf.studies.sweep.rows import INDEX, Kind, Row, is_whole, signed

MANIFEST: Final = "sweep.json"
RESULTS: Final = "results.parquet"
FAILURES: Final = "failures.jsonl"
JOURNAL: Final = "journal.jsonl"
PARTS: Final = "parts"
ROWS_A_PART: Final = 5000
REASON: Final = "reason"
# What the results' file says of itself.
METADATA: Final = b"vrlf.sweep"

_TO_DO, _DONE, _FAILED = range(3)


class SweepFolderError(OutputPathError):
    """The folder holds another sweep, or one that is at work."""


class Store:
    """Rows of one sweep, each index once. Close it, or use ``with``."""

    def __init__(self, folder: Path, plan: Plan, *, rows_a_part: int = ROWS_A_PART) -> None:
        self.folder, self._plan = folder, plan
        self._rows_a_part = rows_a_part
        self._state = bytearray(plan.count)
        self.notes: list[str] = []
        self._journal = Journal(folder / JOURNAL)
        self._failures = Journal(folder / FAILURES)
        self._waiting = 0
        self._part = 0
        self._load()

    @classmethod
    def open(
        cls,
        folder: Path,
        plan: Plan,
        *,
        restart: bool = False,
        retry: bool = False,
        rows_a_part: int = ROWS_A_PART,
    ) -> Self:
        """Begin in a new or empty folder, or go on in one of the same sweep.

        Parameters
        ----------
        restart : bool
            Take away what an earlier run left.
        retry : bool
            Try again what failed.

        Raises
        ------
        OutputPathError
            The folder is of another sweep, of no sweep, or cannot be written.
        """
        make_folder(folder)
        check_target(folder / MANIFEST)
        if restart:
            _empty(folder)
        _require_same(folder, plan)
        if not (folder / MANIFEST).exists():
            text = json.dumps({"sweep": plan.name, **plan.told()}, indent=2) + "\n"
            atomic_write_text(folder / MANIFEST, text)
        make_folder(folder / PARTS)
        store = cls(folder, plan, rows_a_part=rows_a_part)
        if retry:
            store._forget_failures()
        return store

    @property
    def done(self) -> int:
        """How many rows there are."""
        return self._state.count(_DONE)

    @property
    def failed(self) -> int:
        """How many jobs failed."""
        return self._state.count(_FAILED)

    def to_do(self) -> Iterator[int]:
        """The jobs that are neither, one after another, while the others come in."""
        index = self._state.find(_TO_DO)
        while index >= 0:
            yield index
            index = self._state.find(_TO_DO, index + 1)

    def add(self, row: Row) -> bool:
        """Keep a row; False if it is there already.

        Raises
        ------
        OutputError
            The disk is full, or the row came damaged.
        """
        if not is_whole(row) or not 0 <= row[INDEX] < len(self._state):
            raise OutputError("sweep: found a row that its checksum denies, wanted it whole")
        if self._state[row[INDEX]] == _DONE:
            return False
        self._journal.add(row)
        self._state[row[INDEX]] = _DONE
        self._waiting += 1
        if self._waiting >= self._rows_a_part:
            self._seal()
        return True

    def fail(self, job: Job, reason: str) -> None:
        """Note why a job has no row."""
        if self._state[job.index] != _TO_DO:
            return
        self._failures.add(signed({**job.values, REASON: reason}))
        self._state[job.index] = _FAILED

    def failures(self) -> list[Row]:
        """The jobs that failed, by index, each with its ``reason``."""
        found = {row[INDEX]: row for row in self._failures.lines() if is_whole(row)}
        return [found[i] for i in sorted(found) if self._state[i] == _FAILED]

    def finish(self) -> Path:
        """All rows into one file, sorted by index; what they were gathered from goes."""
        import pyarrow as pa

        self._seal()
        place = self.folder / RESULTS
        tables = [self._read(path) for path in (*self._parts(), place) if path.exists()]
        table = pa.concat_tables(tables, promote_options="default") if tables else self._table([])
        table = table.select(self._schema(table.column_names).names)
        _write(place, _each_once(table).replace_schema_metadata(self._metadata()))
        for part in self._parts():
            part.unlink()
        (self.folder / PARTS).rmdir()
        (self.folder / JOURNAL).unlink()
        lines = [json.dumps(row) + "\n" for row in self.failures()]
        if lines:  # by index, and each once
            atomic_write_text(self.folder / FAILURES, "".join(lines))
        else:
            (self.folder / FAILURES).unlink()
        return place

    def close(self) -> None:
        """Let others have the folder."""
        for journal in (self._journal, self._failures):
            journal.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _load(self) -> None:
        """Find out what is there; what is damaged goes and is done again."""
        for path in (self.folder / RESULTS, *self._parts()):
            if not path.exists():
                continue
            try:
                rows = self._read(path).column(INDEX).to_pylist()
            except VrlfError as error:
                self.notes.append(f"{error}; its jobs are done again")
                path.unlink()
                continue
            for index in rows:
                self._state[index] = _DONE
        numbers = [int(path.stem) for path in self._parts()]
        self._part = max(numbers, default=-1) + 1
        for row in self._journal.lines():
            if self._fits(row):
                self._state[row[INDEX]] = _DONE
                self._waiting += 1
        for row in self._failures.lines():
            if self._fits(row) and self._state[row[INDEX]] == _TO_DO:
                self._state[row[INDEX]] = _FAILED

    def _fits(self, row: Any) -> bool:
        return is_whole(row) and 0 <= row[INDEX] < len(self._state)

    def _forget_failures(self) -> None:
        for row in self.failures():
            self._state[row[INDEX]] = _TO_DO
        self._failures.clear()

    def _parts(self) -> list[Path]:
        return sorted((self.folder / PARTS).glob("[0-9]*.parquet"))

    def _seal(self) -> None:
        """The journal's rows become a part; only then does the journal begin anew."""
        rows = [row for row in self._journal.lines() if self._fits(row)]
        if rows:
            path = self.folder / PARTS / f"{self._part:06d}.parquet"
            _write(path, _each_once(self._table(rows)))
            self._part += 1
        self._journal.clear()
        self._waiting = 0

    def _schema(self, names: Collection[str]) -> Any:
        """For rows that have those names."""
        import pyarrow as pa

        types: dict[Kind, Any] = {
            "bool": pa.bool_(), "int": pa.int64(), "float": pa.float64(), "text": pa.string(),
        }  # fmt: skip
        columns = self._plan.columns_of(names)
        return pa.schema([(name, types[kind]) for name, kind in columns.items()])

    def _table(self, rows: list[Row]) -> Any:
        import pyarrow as pa

        names = {name for row in rows for name in row}
        return pa.Table.from_pylist(rows, schema=self._schema(names))

    def _read(self, path: Path) -> Any:
        """A Parquet file whose every row is what its checksum says.

        Raises
        ------
        OutputError
        """
        import pyarrow as pa
        from pyarrow import parquet

        try:
            table = parquet.read_table(path, partitioning=None).replace_schema_metadata(None)
            table = table.cast(self._schema(table.column_names))
            damaged = not all(map(self._fits, rows_of(table)))
        except (pa.ArrowException, OSError, ValueError) as error:
            raise OutputError(
                f"{shown(path)}: found {' '.join(str(error).split())}, wanted rows of this sweep"
            ) from None
        if damaged:
            raise OutputError(f"{shown(path)}: found a row that its checksum denies")
        return table

    def _metadata(self) -> Mapping[bytes, bytes]:
        return {METADATA: json.dumps({"sweep": self._plan.name, **self._plan.told()}).encode()}


def rows_of(table: Any) -> Iterable[Row]:
    """A table's rows, some at a time."""
    for batch in table.to_batches(max_chunksize=1000):
        yield from batch.to_pylist()


def _each_once(table: Any) -> Any:
    """Sorted by index; of an index that is there twice, one row."""
    import numpy as np

    _, first = np.unique(table.column(INDEX).to_numpy(), return_index=True)
    return table.take(first)


def _write(path: Path, table: Any) -> None:
    from pyarrow import parquet

    data = io.BytesIO()
    parquet.write_table(table, data, compression="zstd", write_page_checksum=True)
    atomic_write_bytes(path, data.getvalue())


def _require_same(folder: Path, plan: Plan) -> None:
    manifest = folder / MANIFEST
    if manifest.exists():
        try:
            name = json.loads(manifest.read_text(encoding="utf-8"))["sweep"]
        except (OSError, ValueError, KeyError, TypeError):
            name = None
        if name != plan.name:
            raise SweepFolderError(
                f"{shown(folder)}: found another sweep's results (other keys, rigs, pictures or "
                "vrlf), wanted this one's, an empty folder, or --restart, which takes them away"
            )
        return
    if any((folder / name).exists() for name in (RESULTS, FAILURES, JOURNAL)):
        raise SweepFolderError(
            f"{shown(folder)}: found results that no {MANIFEST} tells of, wanted an empty folder, "
            "or --restart, which takes them away"
        )


def _empty(folder: Path) -> None:
    """Take away what a sweep writes, and nothing else."""
    if (folder / JOURNAL).exists():
        Journal(folder / JOURNAL).close()  # refuses while a sweep is at work
    old = [folder / name for name in (MANIFEST, RESULTS, FAILURES, JOURNAL)]
    for path in (*old, *(folder / PARTS).glob("[0-9]*.parquet")):
        path.unlink(missing_ok=True)

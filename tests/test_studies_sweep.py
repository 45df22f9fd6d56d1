"""A sweep's parts without Dask: jobs by number, rows and their checksums, the folder, one job."""

from __future__ import annotations

import errno
import json
import os
import threading
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_runs import DATA
from pyarrow import parquet
from sweep_runs import kit_for, plan_for, quick, require_whole

from vrlf.app.sweeping import cover_target
from vrlf.errors import InputError, OutputError, OutputPathError
from vrlf.evaluation.measure import likeness
from vrlf.model.sweep import sweep_from_tables
from vrlf.renderer import GpuRenderer, bare_rig
from vrlf.studies.sweep.bench import Bench
from vrlf.studies.sweep.jobs import WorkerUnfitError, kit_of, outcome_of, rig_of
from vrlf.studies.sweep.plan import Plan, drawn, plan_of
from vrlf.studies.sweep.rows import checksum, signed
from vrlf.studies.sweep.store import METADATA, Store

RIG = str(DATA / "lenslets-turned.toml")


def plan(**tables: Any) -> Plan:
    """A sweep of the small rig."""
    given = {"rig": RIG, "sources": "chart:siemens"} | tables
    return plan_of(sweep_from_tables(given), Path(), "spec")


# Jobs by number


def test_every_combination_has_one_number() -> None:
    found = plan(
        sources=["chart:siemens", "chart:grid"],
        methods=["none", "optimal"],
        grid={"array": {"gap_mm": [4.0, 5.0, 6.0]}, "both.sphere_d": [-1, -2.5]},
        sample={"count": 5, "left.pupil_mm": {"from": 2, "to": 3}},
    )
    jobs = [found.job(index) for index in range(found.count)]
    seen = {json.dumps({k: v for k, v in j.values.items() if k != "index"}) for j in jobs}
    assert len(seen) == found.count == 2 * 2 * 3 * 2 * 5
    assert [job.index for job in jobs] == list(range(found.count))
    # The method changes first, then the source, then the last key of the grid.
    assert [job.method for job in jobs[:2]] == ["none", "optimal"]
    assert [job.source for job in jobs[1:3]] == ["chart:siemens", "chart:grid"]
    assert [job.values["both.sphere_d"] for job in jobs[3:5]] == [-1.0, -2.5]
    assert [job.values["array.gap_mm"] for job in jobs[7:9]] == [4.0, 5.0]
    assert jobs[4].changes["right"] == {"sphere_d": -2.5}
    assert jobs[4].changes["left"]["sphere_d"] == -2.5


def test_a_list_is_a_value_and_a_column_of_text() -> None:
    found = plan(grid={"array.offset_um": [[0.0, 0.0], [7.0, -3.0]]})
    assert found.columns["array.offset_um"] == "text"
    last = found.job(found.count - 1)
    assert last.values["array.offset_um"] == "[7.0, -3.0]"
    assert rig_of(kit_of(found, cover_target), last).array.offset_um == (7.0, -3.0)


@pytest.mark.parametrize("kind", ["latin-hypercube", "sobol"])
def test_a_sample_fills_its_box_evenly_and_again(kind: str) -> None:
    table = {"from": 2.0, "to": 6.0}, {"from": 10.0, "to": 1000.0, "log": True}
    given = {"count": 64, "seed": 5, "kind": kind, "left.pupil_mm": table[0]}
    sample = plan(sample=given | {"array.pitch_um": table[1]}).spec.sample
    assert sample is not None
    points = drawn(sample)
    np.testing.assert_array_equal(points, drawn(sample))
    assert not np.array_equal(points, drawn(sample.model_copy(update={"seed": 6})))
    unit = np.stack([(points[:, 0] - 2.0) / 4.0, np.log10(points[:, 1] / 10.0) / 2.0], axis=1)
    # One point in each of 64 slices of each key: what both kinds promise.
    for column in unit.T:
        assert sorted(np.floor(column * 64).astype(int)) == list(range(64))


def test_a_sweep_is_known_by_its_spec_its_rig_and_its_pictures(tmp_path: Path) -> None:
    picture = tmp_path / "a.png"
    picture.write_bytes(b"one")
    names = [plan(sources=str(picture)).name, plan(sources=str(picture), rays=7).name]
    picture.write_bytes(b"two")
    names.append(plan(sources=str(picture)).name)
    names.append(plan(sources=str(picture), rig="matched-wide").name)
    assert len(set(names)) == 4
    assert plan(sources=str(picture)).name == names[2]


@pytest.mark.parametrize(
    ("key", "values", "complaint"),
    [
        ("left.spher_d", [1.0], 'left.spher_d: found an unknown key, wanted "sphere_d"'),
        ("left.sphere_d", ["x"], "left.sphere_d: found "),
        ("lefty.sphere_d", [1.0], "lefty: found an unknown key"),
    ],
)
def test_keys_that_no_rig_has_are_refused_at_once(
    key: str, values: list[Any], complaint: str
) -> None:
    with pytest.raises(InputError, match="spec: ") as caught:
        plan(grid={key: values})
    assert complaint in str(caught.value)


def test_one_good_value_is_enough_to_begin() -> None:
    assert plan(grid={"left.pupil_mm": [-1.0, 3.0]}).count == 6


# Rows


def test_a_checksum_knows_every_value_and_no_order() -> None:
    row = {"index": 3, "a": 0.1 + 0.2, "b": None, "c": "x"}
    assert checksum(row) == checksum(dict(reversed(row.items())))
    assert checksum(row) == checksum({"index": 3, "a": 0.30000000000000004, "c": "x"})
    assert checksum(row) != checksum(row | {"a": 0.3})
    assert checksum(signed(row)) == checksum(row)


# The folder


def filled(folder: Path, jobs: int, rows_a_part: int = 4, upto: int | None = None) -> Plan:
    """A sweep's folder with its rows up to one, not finished."""
    found = plan_for(jobs)
    with Store.open(folder, found, rows_a_part=rows_a_part) as store:
        for index in list(store.to_do())[:upto]:
            store.add(row_of(found, index))
    return found


def row_of(found: Plan, index: int) -> dict[str, Any]:
    """What a worker would send."""
    outcome = outcome_of(kit_for(found), found.job(index), lambda: pytest.fail("no GPU here"))
    assert outcome.row is not None
    return outcome.row


def test_rows_come_in_any_order_twice_and_stand_once_in_order(tmp_path: Path) -> None:
    found = plan_for(20)
    with Store.open(tmp_path, found, rows_a_part=3) as store:
        for index in np.random.default_rng(1).permutation(20).tolist():
            assert store.add(row_of(found, index))
            assert not store.add(row_of(found, index))
        store.finish()
    require_whole(tmp_path, found)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["results.parquet", "sweep.json"]
    told = json.loads(parquet.read_schema(tmp_path / "results.parquet").metadata[METADATA])
    assert told["sweep"] == found.name
    assert told["rigs"].keys() == {"matched-microlens"}


def test_a_row_on_the_way_to_a_part_is_not_doubled(tmp_path: Path) -> None:
    found = filled(tmp_path, 12, rows_a_part=4, upto=7)
    # As if the run had ended between the part and the emptying of the journal.
    part = parquet.read_table(tmp_path / "parts" / "000000.parquet").to_pylist()
    with (tmp_path / "journal.jsonl").open("a") as journal:
        journal.writelines(json.dumps(row) + "\n" for row in part)
    finish(tmp_path, found, done=7)


def finish(folder: Path, found: Plan, *, done: int) -> list[str]:
    """Go on in a folder that holds so many rows; the notes that the store made."""
    with Store.open(folder, found) as store:
        assert store.done == done
        for index in store.to_do():
            store.add(row_of(found, index))
        store.finish()
        require_whole(folder, found)
        return store.notes


def test_a_torn_line_is_taken_off_and_a_damaged_one_done_again(tmp_path: Path) -> None:
    found = filled(tmp_path, 12, rows_a_part=100, upto=6)
    journal = tmp_path / "journal.jsonl"
    lines = journal.read_text().splitlines(keepends=True)
    lines[2] = lines[2].replace('"rmse', '"rmsf').replace("0.", "1.", 1)
    journal.write_text("".join(lines[:5]) + lines[5][:40])
    finish(tmp_path, found, done=4)


def test_a_damaged_part_is_done_again(tmp_path: Path) -> None:
    found = filled(tmp_path, 12, rows_a_part=4)
    part = tmp_path / "parts" / "000001.parquet"
    table = parquet.read_table(part)
    column = table.schema.get_field_index("left_rmse")
    changed = [v + 1e-9 for v in table.column(column).to_pylist()]
    parquet.write_table(table.set_column(column, "left_rmse", [changed]), part)
    (tmp_path / "parts" / "000002.parquet").write_bytes(b"PAR1")
    notes = finish(tmp_path, found, done=4)
    assert [("checksum" in note, "done again" in note) for note in notes] == [
        (True, True),
        (False, True),
    ]


def test_a_damaged_row_is_not_taken(tmp_path: Path) -> None:
    found = plan_for(4)
    with Store.open(tmp_path, found) as store, pytest.raises(OutputError, match="checksum denies"):
        store.add(row_of(found, 2) | {"left_rmse": 0.0})


def test_failures_are_kept_and_can_be_tried_again(tmp_path: Path) -> None:
    found = plan_for(4)
    with Store.open(tmp_path, found) as store:
        store.fail(found.job(2), "no such rig")
        for index in list(store.to_do()):
            store.add(row_of(found, index))
        assert (store.done, store.failed) == (3, 1)
        store.finish()
    with Store.open(tmp_path, found) as store:
        assert [(row["index"], row["reason"]) for row in store.failures()] == [(2, "no such rig")]
        assert list(store.to_do()) == []
    with Store.open(tmp_path, found, retry=True) as store:
        assert list(store.to_do()) == [2]
        store.add(row_of(found, 2))
        store.finish()
    require_whole(tmp_path, found)


def test_another_sweeps_folder_is_refused_and_restart_takes_it(tmp_path: Path) -> None:
    filled(tmp_path, 4)
    (tmp_path / "mine.txt").write_text("the user's")
    other = plan_for(6)
    with pytest.raises(OutputPathError, match="found another sweep's results"):
        Store.open(tmp_path, other)
    with Store.open(tmp_path, other, restart=True) as store:
        assert store.done == 0
    (tmp_path / "sweep.json").unlink()
    with pytest.raises(OutputPathError, match=r"no sweep\.json tells of"):
        Store.open(tmp_path, other)
    assert (tmp_path / "mine.txt").exists()


def test_two_at_once_are_refused(tmp_path: Path) -> None:
    pytest.importorskip("fcntl", reason="no locks that free themselves on this system")
    found = plan_for(4)
    with Store.open(tmp_path, found):
        for restart in (False, True):
            with pytest.raises(OutputPathError, match="another sweep at work"):
                Store.open(tmp_path, found, restart=restart)
    Store.open(tmp_path, found).close()


def test_a_full_disk_is_said_and_loses_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    found = plan_for(12)
    write = os.write

    def full(file: int, data: bytes) -> int:
        write(file, bytes(data)[:10])
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with Store.open(tmp_path, found) as store:
        for index in range(5):
            store.add(row_of(found, index))
        with monkeypatch.context() as patch:
            patch.setattr(os, "write", full)
            with pytest.raises(OutputError, match="No space left on device"):
                store.add(row_of(found, 5))
        assert store.done == 5
    assert (tmp_path / "journal.jsonl").read_bytes().endswith(b"\n")
    finish(tmp_path, found, done=5)


def test_metrics_of_several_values_have_a_column_each(tmp_path: Path) -> None:
    found = plan_for(4)
    with Store.open(tmp_path, found, rows_a_part=1) as store:
        for index in range(4):
            several = {f"left_rmse.{index % 2}": float(index), "right_rmse": None}
            row = {k: v for k, v in row_of(found, index).items() if "rmse" not in k}
            store.add(signed(row | several))
        store.finish()
    rows = parquet.read_table(tmp_path / "results.parquet").to_pylist()
    assert [row["checksum"] for row in rows] == [checksum(row) for row in rows]
    assert [row["left_rmse.1"] for row in rows] == [None, 1.0, None, 3.0]
    assert "left_rmse" not in rows[0]


# One job


def test_a_job_says_what_the_bench_would() -> None:
    found = plan(rays=8, panel_px=[96, 64], methods=["none", "forward"])
    kit = kit_of(found, cover_target)
    with GpuRenderer() as renderer:
        rows = [outcome_of(kit, found.job(index), lambda: renderer).row for index in range(2)]
        rig = rig_of(kit, found.job(1))
        target = cover_target("chart:siemens", rig, renderer)
        bare = renderer.perceive(target, bare_rig(rig), rays=8)
        corrected = renderer.perceive(renderer.prefilter(target, rig), rig, rays=8)
    assert rig.prefilter.method == "forward"
    for row, seen in zip(rows, (bare, corrected), strict=True):
        assert row is not None
        for side in ("left", "right"):
            expected = likeness(seen, target, rig, side)  # type: ignore[arg-type]
            assert row[f"{side}_rmse"] == expected.rmse
            assert row[f"{side}_psnr_db"] == expected.psnr_db
    assert rows[0] != rows[1]


class Dimmed:
    """In a renderer's place: shows 0.2 of black and 0.6 of white, by any method."""

    def prefilter(self, target: Any, _: Any) -> Any:
        return 0.2 + 0.4 * target

    def perceive(self, panel: Any, _: Any, *, rays: int) -> Any:
        assert rays == 8
        return panel


@pytest.mark.parametrize(("method", "is_right"), [("optimal", True), ("forward", False)])
def test_black_is_taken_off_before_optimal_alone_is_judged(method: str, is_right: bool) -> None:
    given = {"prefilter.black_level": [0.2], "prefilter.brightness": [0.6]}
    found = plan(rays=8, panel_px=[96, 64], methods=method, grid=given)
    kit = replace(kit_of(found, cover_target), target_of=lambda _, rig, __: noise(rig))
    row = outcome_of(kit, found.job(0), Dimmed).row  # type: ignore[arg-type]
    assert row is not None
    # float32 pictures: what is left of an exact match is their rounding.
    assert (row["right_rmse"] < 1e-7) == is_right


def test_any_metric_of_the_registry_can_be_asked_for() -> None:
    names = ["rmse", "hdr_vdp", "fringe", "light"]
    found = plan(rays=8, panel_px=[96, 64], methods="none", metrics=names)
    kit = replace(kit_of(found, cover_target), target_of=lambda _, rig, __: noise(rig))
    row = outcome_of(kit, found.job(0), Dimmed).row  # type: ignore[arg-type]
    assert row is not None
    assert row["left_light"] == pytest.approx(1.0, abs=1e-6)  # shown as it is: nothing is lost
    assert row["left_hdr_vdp.p_det"] == pytest.approx(0.0, abs=1e-6)
    assert row["right_fringe"] == pytest.approx(0.0, abs=1e-6)


def noise(rig: Any) -> Any:
    """A picture that no gain alone makes of a dimmed one."""
    size = (rig.panel.height_px, rig.panel.width_px, 3)
    return np.random.default_rng(2).random(size, np.float32)


def test_an_impossible_rig_fails_alone_and_in_one_line() -> None:
    found = plan(grid={"left.pupil_mm": [-1.0, 3.0]})
    outcome = outcome_of(kit_of(found, cover_target), found.job(0), lambda: pytest.fail("no GPU"))
    assert outcome.row is None
    assert outcome.reason is not None
    assert "left.pupil_mm: found -1.0, wanted" in outcome.reason


def test_an_unknown_metric_is_refused() -> None:
    with pytest.raises(InputError, match="metrics: found 'sharpness', wanted some of rmse"):
        kit_of(plan(metrics="sharpness"), cover_target)


# A worker's bench


def test_a_worker_has_one_context_on_a_thread_of_its_own_and_gives_it_back() -> None:
    found = plan(rays=4, panel_px=[96, 64], methods="none", grid={"left.sphere_d": [-1.0, 0.0]})
    seen: list[tuple[int, GpuRenderer]] = []

    def judge(kit: Any, _: Any, renderer: Any) -> dict[str, float | None]:
        seen.append((threading.get_ident(), renderer()))
        assert not seen[0][1].device._released
        return dict.fromkeys(kit.metrics, 0.0)

    bench = Bench(replace(kit_of(found, cover_target), judge=judge))
    assert bench.contexts == 0
    # As Dask may: jobs from several threads.
    callers = [threading.Thread(target=bench.do, args=(found.job(i),)) for i in range(2)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert bench.contexts == 1
    assert len({thread for thread, _ in seen}) == 1
    assert seen[0][0] not in {threading.get_ident(), *(caller.ident for caller in callers)}
    assert seen[0][1] is seen[1][1]
    bench.release()
    assert bench.contexts == 0
    assert seen[0][1].device._released


def test_a_worker_with_another_vrlf_or_picture_is_unfit(tmp_path: Path) -> None:
    picture = tmp_path / "a.png"
    picture.write_bytes(b"one")
    found = plan(sources=str(picture))
    kit = replace(kit_of(found, cover_target), judge=quick)
    picture.write_bytes(b"two")
    for each, complaint in (
        (kit, "found another file than the sweep began with"),
        (replace(kit, version="0.0.1"), r"wanted 0\.0\.1"),
    ):
        bench = Bench(each)
        with pytest.raises(WorkerUnfitError, match=complaint):
            bench.do(found.job(0))
        bench.release()

"""`flatland study`: many cases, kept one by one, as one data set."""

from __future__ import annotations

import json
import os
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from studies.sweeps.engines import Engine
    from studies.sweeps.runner import Outcome
    from studies.sweeps.study import Study

#: Failures that are printed; the data set has all of them.
_MOST_SHOWN = 10


@click.command("study")
@click.argument("name", required=False)
@click.option(
    "-o", "--output", type=click.Path(path_type=Path), help="Folder. [default: out/studies/NAME]"
)
@click.option("--jobs", type=int, help="Processes at once; 1: in this one. [default: all cores]")
@click.option("--resume", is_flag=True, help="Go on with the study in the folder; NAME may go.")
@click.option("--keep-failed", is_flag=True, help="Do not try failed cases again.")
@click.option("--dask", metavar="ADDRESS", help="Run on the Dask cluster of this scheduler.")
@click.option("--set", "changes", multiple=True, metavar="KEY=VALUE", help="Change a key, as TOML.")
@click.option("--show", is_flag=True, help="Print the study as TOML, run nothing.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON for machines.")
def command(
    name: str | None,
    output: Path | None,
    jobs: int | None,
    resume: bool,
    keep_failed: bool,
    dask: str | None,
    changes: tuple[str, ...],
    show: bool,
    as_json: bool,
) -> None:
    """Run the study NAME, built in or a TOML file; `list`, or no name, lists those built in.

    Finished cases are kept in the folder and skipped when the study is run again, there or after
    it was interrupted or killed; failed ones are tried again.
    """
    if name == "list" or (name is None and not resume):
        _list(as_json)
        return
    study = _chosen(name, output, resume, changes)
    if show:
        click.echo(study.to_toml(), nl=False)
        return
    folder = output or Path("out") / "studies" / study.name
    outcome = _run(study, folder, _engine(jobs, dask), retry=not keep_failed)
    click.echo(json.dumps(_record(study, outcome), indent=1) if as_json else _report(outcome))
    if outcome.failed:
        from studies.command_line import FAILED

        raise click.exceptions.Exit(FAILED)


def _list(as_json: bool) -> None:
    from studies.sweeps.study import builtin_studies, load_study
    from studies.tables import table

    rows = [(name, load_study(name).title) for name in builtin_studies()]
    shown = json.dumps(dict(rows), indent=1) if as_json else table(["study", "shows"], rows)
    click.echo(shown)


def _chosen(name: str | None, output: Path | None, resume: bool, changes: tuple[str, ...]) -> Study:
    from dataclasses import replace

    from flatland.errors import bad_input
    from studies.sweeps.study import load_study

    if name is not None:
        study = load_study(name)
    elif output is None:
        raise bad_input("--resume", resume, "needs the name of a study or, by -o, its folder")
    else:
        study = replace(load_study(str(output / "study.toml")), name=output.absolute().name)
    return study.with_values(_values(changes)) if changes else study


def _values(changes: tuple[str, ...]) -> dict[str, Any]:
    """`key=value` texts, values as TOML; words need no quotes."""
    import tomllib

    from flatland.errors import bad_input

    values = {}
    for text in changes:
        key, equals, value = text.partition("=")
        if not equals:
            raise bad_input("--set", text, "must be key=value, as in bands=[2,4]")
        try:
            values[key.strip()] = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            values[key.strip()] = value.strip()
    return values


def _engine(jobs: int | None, dask: str | None) -> Engine:
    from studies.sweeps.engines import local_engine

    if dask is None:
        return local_engine(jobs)
    from studies.sweeps.dask_engine import Dask

    return Dask(dask)


def _run(study: Study, folder: Path, engine: Engine, retry: bool) -> Outcome:
    """Run with progress; an interrupt says how to go on."""
    from studies.command_line import INTERRUPTED
    from studies.progress import study_progress
    from studies.sweeps.runner import run_study
    from studies.sweeps.store import CaseStore

    with study_progress() as watcher, suppress(KeyboardInterrupt):
        return run_study(study, folder, engine, watcher, retry)
    # An interrupt may fall between a case's file and the watcher's count of it: the files tell.
    keys = [case.key for case in study.cases()]
    click.echo(
        f"flatland: interrupted; {CaseStore(folder).count(keys)} of {len(keys)} cases are finished "
        f"and kept; go on with: flatland study --resume -o {os.fspath(folder)}",
        err=True,
    )
    raise click.exceptions.Exit(INTERRUPTED)


def _report(outcome: Outcome) -> str:
    lines = [f"{outcome.done} cases done, {outcome.kept} kept, {len(outcome.failed)} failed"]
    lines += [f"failed: {case.label}: {text}" for case, text in outcome.failed[:_MOST_SHOWN]]
    if len(outcome.failed) > _MOST_SHOWN:
        lines.append(f"… and {len(outcome.failed) - _MOST_SHOWN} more, see the data set")
    return "\n".join([*lines, f"wrote {outcome.dataset} and {outcome.csv}"])


def _record(study: Study, outcome: Outcome) -> dict[str, Any]:
    return {
        "study": study.name,
        "dataset": str(outcome.dataset),
        "csv": str(outcome.csv),
        "done": outcome.done,
        "kept": outcome.kept,
        "failed": [
            {"case": case.key, "label": case.label, "reason": text} for case, text in outcome.failed
        ],
    }

"""`flatland scene`: built-in scenes, and scene files."""

from __future__ import annotations

from pathlib import Path

import click


@click.group("scene")
def command() -> None:
    """List, show, check and start scene files."""


@command.command("list")
def list_scenes() -> None:
    """Names of the built-in scenes, with what they show."""
    from flatland.scene import builtin_names, load_scene
    from studies.tables import table

    rows = []
    for name in builtin_names():
        scene = load_scene(name)
        size = " x ".join(map(str, scene.grid.shape))
        rows.append([name, size, scene.title])
    click.echo(table(["scene", "cells", "shows"], rows))


@command.command()
@click.argument("scene")
def show(scene: str) -> None:
    """Print SCENE (a built-in name or a file) as TOML."""
    from flatland.scene import builtin_names, builtin_text, load_scene, scene_to_toml

    if scene.split(":")[0] in builtin_names():
        click.echo(builtin_text(scene), nl=False)
    else:
        click.echo(scene_to_toml(load_scene(scene)), nl=False)


@command.command()
@click.argument("files", nargs=-1, required=True)
def check(files: tuple[str, ...]) -> None:
    """Validate scene FILES; reports every mistake of each."""
    from flatland.errors import InputError
    from flatland.scene import load_scene
    from studies.command_line import BAD_INPUT

    failed = False
    for name in files:
        try:
            scene = load_scene(name)
        except InputError as error:
            failed = True
            click.echo(str(error), err=True)
        else:
            count = f"{len(scene.lights)} lights, {len(scene.occluders)} occluders"
            size = " x ".join(map(str, scene.grid.shape))
            click.echo(f"{name}: good: {size} cells, {count}")
    if failed:
        raise click.exceptions.Exit(BAD_INPUT)


@command.command()
@click.argument("file", type=click.Path(path_type=Path))
@click.option("--dimension", default=2, show_default=True, help="2 or 3.")
@click.option("--force", is_flag=True, help="Replace the file if it exists.")
def new(file: Path, dimension: int, force: bool) -> None:
    """Write a commented scene FILE to start from."""
    from flatland.errors import bad_input
    from flatland.results import write_atomically
    from flatland.scene import scene_template

    if file.exists() and not force:
        raise bad_input("file", str(file), "exists already; --force replaces it")
    text = scene_template(dimension)
    write_atomically(file, lambda place: place.write_text(text, encoding="utf-8"))
    click.echo(f"wrote {file}")

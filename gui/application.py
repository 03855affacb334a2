"""`flatland-gui`: the desktop, or one picture of it."""

from __future__ import annotations

import os
import sys
import time
import traceback
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gui.system_libraries import missing_library, require_display

if TYPE_CHECKING:
    from PySide6.QtWidgets import QApplication

    from gui.window import Window

FAILED, BAD_INPUT, INTERRUPTED = 1, 2, 130


@click.command("flatland-gui", context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="flatland-light", prog_name="flatland-gui")
@click.argument("scene", required=False)
@click.option("--propagator", help="A scheme's name.")
@click.option("--option", "options", multiple=True, metavar="KEY=VALUE", help="Of the scheme.")
@click.option("--bands", type=int, help="Angular bands.")
@click.option("--levels", type=int, help="Octree levels.")
@click.option("--iterations", type=int, metavar="N", help="Steps to begin with.")
@click.option("--converge", is_flag=True, help="Begin with the converged field.")
@click.option("--reference", is_flag=True, help="Compute the exact answer too.")
@click.option("--views", help="Which views, as in source,accumulated,reference.")
@click.option("--theme", help="light, dark or system.")
@click.option("--screenshot", type=click.Path(path_type=Path), help="Picture to write (PNG).")
@click.option("--size", default="1360x860", show_default=True, help="Of the window.")
def command(
    scene: str | None,
    propagator: str | None,
    options: tuple[str, ...],
    bands: int | None,
    levels: int | None,
    iterations: int | None,
    converge: bool,
    reference: bool,
    views: str | None,
    theme: str | None,
    screenshot: Path | None,
    size: str,
) -> int:
    """Open SCENE, a built-in name or a file, in a window.

    With --screenshot the window is drawn into a file and closed; no display is needed.
    """
    from flatland.errors import FlatlandError

    width, height = _size(size)
    if screenshot is not None:
        _check_picture(screenshot)
        os.environ.setdefault("QT_QPA_PLATFORM", "offscreen")
        os.environ.setdefault("QT_LOGGING_RULES", "qt.qpa.*=false")
    require_display()
    application = make_application()
    window = make_window(scene, screenshot is not None, theme)
    try:
        _choose(window, propagator, options, {"bands": bands, "levels": levels}, views)
    except FlatlandError:
        window.shut_down()
        raise
    window.resize(width, height)
    window.show()
    window.session.begin()
    if iterations is not None and iterations > 0:
        window.session.submit("step", count=iterations)
    if converge:
        window.session.solve()
    if reference:
        window.session.reference.compute()
    if screenshot is not None:
        return _take_picture(application, window, screenshot)
    _begin(window, scene)
    return int(application.exec())


def make_application() -> QApplication:
    """The one application, with a hook that turns exceptions into messages."""
    from PySide6.QtWidgets import QApplication

    existing = QApplication.instance()
    application = existing if isinstance(existing, QApplication) else QApplication(sys.argv[:1])
    # The worker hands the interpreter back this soon when the window wants it [s].
    sys.setswitchinterval(5e-4)
    application.setApplicationName("flatland")
    application.setOrganizationName("flatland")
    application.setApplicationDisplayName("flatland")
    return application


def make_window(scene: str | None, bare: bool = False, theme: str | None = None) -> Window:
    """A window with a scene. bare: with no settings of the user, and none stored.

    Raises SceneError if the scene cannot be read, InputError for an unknown theme.
    """
    from flatland.errors import bad_input
    from gui.models.document import SceneDocument
    from gui.models.session import Session
    from gui.models.settings import THEMES, Settings
    from gui.window import Window

    settings = Settings.in_memory() if bare else Settings.of_user()
    if theme is not None:
        if theme not in THEMES:
            raise bad_input("--theme", theme, "is unknown", THEMES)
        settings.theme = theme
    document = SceneDocument.open(scene or "fig5-one-light")
    window = Window(Session(document, settings.look), settings, None if bare else _state_folder())
    install_hook(window)
    return window


def _state_folder() -> Path:
    import platformdirs

    return Path(platformdirs.user_state_dir("flatland"))


def install_hook(window: Window) -> None:
    """An exception that nobody caught becomes a message; the window stays."""

    def hook(kind: type[BaseException], error: BaseException, trace: Any) -> None:
        if issubclass(kind, KeyboardInterrupt):
            window.close()
            return
        details = "".join(traceback.format_exception(kind, error, trace))
        sys.stderr.write(details)
        window.controller.tell_failure("A fault of flatland", f"{kind.__name__}: {error}", details)

    sys.excepthook = hook


def _choose(
    window: Window,
    propagator: str | None,
    options: tuple[str, ...],
    values: dict[str, int | None],
    views: str | None,
) -> None:
    """What the command line says about method and views. Raises InputError."""
    from dataclasses import replace

    from flatland.errors import bad_input
    from flatland.octree import level_grids
    from gui.models.display import VIEWS
    from propagators.registry import find
    from studies.commands.options import scheme_options

    session = window.session
    choice = session.choice
    if propagator is not None:
        find(propagator)
        choice = replace(choice, propagator=propagator, options={})
    if options:
        given = choice.method().propagator.__class__(**scheme_options(options)).values
        named = {name: given[name] for name in scheme_options(options)}
        choice = replace(choice, options=named)
    stated: dict[str, Any] = {name: value for name, value in values.items() if value is not None}
    choice = replace(choice, **stated)
    level_grids(session.scene.grid, choice.levels)
    choice.method().propagator.require_dimension(session.scene.grid.dimension)
    session.choose(choice)
    if views is not None:
        names = tuple(views.split(","))
        for name in names:
            if name not in VIEWS:
                raise bad_input("--views", name, "is unknown", VIEWS)
        session.display.set(views=tuple(v for v in VIEWS if v in names))


def _begin(window: Window, scene: str | None) -> None:
    """What a sitting begins with: a scene that was lost, or the gallery if none was named."""
    from PySide6.QtCore import QTimer

    def begin() -> None:
        if not window.recovery.offer() and scene is None:
            window.controller.gallery()

    QTimer.singleShot(0, begin)


def _take_picture(application: QApplication, window: Window, path: Path) -> int:
    """Wait until everything asked for is on show, write the picture, and close."""
    from gui.export import png_bytes
    from gui.models.storage import store_bytes

    failures: list[str] = []
    window.session.failed.connect(lambda title, text, details: failures.append(text))
    settle(application, window)
    try:
        if not failures:
            content = png_bytes(window.grab().toImage())
            store_bytes(path, content)
            click.echo(f"wrote {path}", err=True)
    finally:
        window.shut_down()
    for text in dict.fromkeys(failures):
        click.echo(f"flatland-gui: error: {text}", err=True)
    return FAILED if failures else 0


def settle(application: QApplication, window: Window, seconds: float = 600.0) -> bool:
    """Let the window finish what it is at; whether it did in time."""
    end = time.monotonic() + seconds
    calm = 0
    while time.monotonic() < end and calm < 5:
        application.processEvents()
        session = window.session
        waiting = window.worker.waiting + window.reference_worker.waiting
        busy = waiting or session.busy or session.reference.computing
        calm = 0 if busy else calm + 1
        time.sleep(0.01)
    application.processEvents()
    return calm >= 5


def _size(text: str) -> tuple[int, int]:
    from flatland.errors import bad_input

    width, cross, height = text.lower().partition("x")
    if not (cross and width.isdecimal() and height.isdecimal()):
        raise bad_input("--size", text, "must be WIDTHxHEIGHT, as in 1360x860")
    if not (200 <= int(width) <= 8000 and 200 <= int(height) <= 8000):
        raise bad_input("--size", text, "must be from 200 to 8000 pixels each way")
    return int(width), int(height)


def _check_picture(path: Path) -> None:
    from flatland.errors import bad_input

    if path.suffix.lower() != ".png":
        raise bad_input("--screenshot", str(path), "has no known ending", (".png",))


def main(arguments: list[str] | None = None) -> None:
    """Run and leave with 0, 1 (ran and failed) or 2 (bad input)."""
    sys.exit(_run(arguments))


def _run(arguments: list[str] | None) -> int:
    from flatland.errors import FlatlandError, InputError

    try:
        code = command.main(args=arguments, standalone_mode=False)
    except click.ClickException as error:
        error.show()
        return BAD_INPUT
    except (click.Abort, KeyboardInterrupt):
        return INTERRUPTED
    except FlatlandError as error:
        click.echo(f"flatland-gui: error: {error}", err=True)
        return BAD_INPUT if isinstance(error, InputError) else FAILED
    except ImportError as error:
        click.echo(f"flatland-gui: error: {missing_library(error)}", err=True)
        return FAILED
    return code if isinstance(code, int) else 0


if __name__ == "__main__":
    main()

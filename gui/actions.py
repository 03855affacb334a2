"""Every command of the window: one table for menus, keys, tool tips and the palette."""

from __future__ import annotations

from dataclasses import dataclass

from gui.models.display import LAYERS, VIEWS
from gui.models.display import MEANINGS as VIEW_MEANINGS
from gui.models.tools import MEANINGS as TOOL_MEANINGS
from gui.models.tools import Tool


@dataclass(frozen=True)
class Command:
    """name: of the window's method that does it. keys: the first is shown; "" for none."""

    name: str
    menu: str
    text: str
    keys: tuple[str, ...] = ()
    tip: str = ""
    checkable: bool = False
    #: Handed to the method, where several commands share one.
    argument: str = ""


def _c(name: str, menu: str, text: str, keys: str = "", tip: str = "", **more: object) -> Command:
    return Command(name, menu, text, tuple(keys.split()), tip, **more)  # type: ignore[arg-type]


COMMANDS: tuple[Command, ...] = (
    _c("new", "File", "New", "Ctrl+N", "A scene to start from"),
    _c("open", "File", "Open…", "Ctrl+O", "Open a scene file"),
    _c("gallery", "File", "Built-in scenes…", "Ctrl+B", "Choose one of the scenes that come along"),
    _c("save", "File", "Save", "Ctrl+S", "Save the scene; comments in the file stay"),
    _c("save_as", "File", "Save as…", "Ctrl+Shift+S", "Save the scene under another name"),
    _c("export_view", "File", "Export view…", "Ctrl+E", "The views as PDF, SVG or PNG"),
    _c(
        "export_animation",
        "File",
        "Export animation…",
        "Ctrl+Shift+E",
        "All iterations so far as an animated GIF",
    ),
    _c("export_data", "File", "Export data…", "", "The fields on show as a netCDF result file"),
    _c("export_curves", "File", "Export curves…", "", "Energy and errors as CSV or PDF"),
    _c("copy_picture", "File", "Copy picture", "Ctrl+Alt+C", "The views to the clipboard"),
    _c(
        "copy_command",
        "File",
        "Copy as command line",
        "Ctrl+Shift+C",
        "The command that gives the numbers on show",
    ),
    _c("copy_scene", "File", "Copy scene as TOML", "Ctrl+Shift+T", "The whole scene as text"),
    _c("quit", "File", "Quit", "Ctrl+Q"),
    _c("undo", "Edit", "Undo", "Ctrl+Z"),
    _c("redo", "Edit", "Redo", "Ctrl+Shift+Z Ctrl+Y"),
    _c("cut", "Edit", "Cut", "Ctrl+X", "Cut the selected lights and occluders"),
    _c("copy", "Edit", "Copy", "Ctrl+C", "Copy the selected lights and occluders"),
    _c("paste", "Edit", "Paste", "Ctrl+V", "Paste lights and occluders, a cell aside"),
    _c("delete", "Edit", "Delete", "Delete Backspace", "Remove the selected items"),
    _c("select_all", "Edit", "Select all", "Ctrl+A"),
    _c("rotate_left", "Edit", "Rotate left", "R", "Turn the selection by 90° to the left"),
    _c("rotate_right", "Edit", "Rotate right", "Shift+R", "Turn the selection by 90° to the right"),
    _c("mirror_across", "Edit", "Mirror left to right", "M", "Mirror the selection"),
    _c("mirror_down", "Edit", "Mirror top to bottom", "Shift+M", "Mirror the selection"),
    _c("nudge_left", "Edit", "Move left", "Alt+Left", "Move the selection by a cell"),
    _c("nudge_right", "Edit", "Move right", "Alt+Right", "Move the selection by a cell"),
    _c("nudge_up", "Edit", "Move up", "Alt+Up", "Move the selection by a cell"),
    _c("nudge_down", "Edit", "Move down", "Alt+Down", "Move the selection by a cell"),
    _c("clear_lights", "Edit", "Clear lights", "Ctrl+L", "Remove all lights, keep occluders"),
    _c("clear_occluders", "Edit", "Clear occluders", "Ctrl+K", "Remove all occluders, keep lights"),
    _c("edit_text_dialog", "Edit", "Scene as text…", "Ctrl+T", "Edit the scene's TOML"),
    _c("run", "Run", "Run", "Space", "Step until paused, at the pace set beside", checkable=True),
    _c("step", "Run", "Step", "Right", "One more iteration"),
    _c("back", "Run", "Step back", "Left", "One iteration back"),
    _c("step_many", "Run", "Ten steps", "Shift+Right", "Ten more iterations"),
    _c("back_many", "Run", "Ten steps back", "Shift+Left", "Ten iterations back"),
    _c("first", "Run", "First iteration", "Home", "Back to the light as it was injected"),
    _c("last", "Run", "Last iteration", "End", "To the last iteration reached"),
    _c("run_count", "Run", "Run n", "N", "As many iterations as the box says, at full speed"),
    _c("solve", "Run", "Converge", "C", "Solve for the converged field"),
    _c("stop", "Run", "Stop", "Esc", "Cancel what is being computed"),
    _c("inject", "Run", "Inject", "I", "Lights into their cells: iteration 0"),
    _c("downsample", "Run", "Downsample", "D", "Fill coarser levels with the mean of finer ones"),
    _c("merge", "Run", "Merge", "G", "Every cell from the finest level that holds light"),
    _c("reset", "Run", "Reset", "Shift+I", "No light anywhere"),
    _c("faster", "Run", "Faster", "+ =", "Twice as many steps a second"),
    _c("slower", "Run", "Slower", "-", "Half as many steps a second"),
    _c("reference", "Run", "Exact answer", "X", "Compute the exact answer and the errors"),
    _c("keep", "Run", "Keep this run", "K", "Draw it beside the next ones, in cells and curves"),
    *(
        _c(
            "tool",
            "Tools",
            t.label,
            str(t.value),
            TOOL_MEANINGS[t],
            checkable=True,
            argument=t.name,
        )
        for t in Tool
    ),
    *(
        _c(
            "view",
            "View",
            v.capitalize(),
            f"F{2 + i}",
            VIEW_MEANINGS[v],
            checkable=True,
            argument=v,
        )
        for i, v in enumerate(VIEWS)
    ),
    _c("one_view", "View", "One large view", "F", "One view alone, or those that were on show"),
    _c("fit", "View", "Whole grid", "0", "Show the whole grid"),
    _c("zoom_in", "View", "Zoom in", "Ctrl++ Ctrl+="),
    _c("zoom_out", "View", "Zoom out", "Ctrl+-"),
    _c("scale_kind", "View", "Linear or logarithmic", "L", "Change the scale of the lobes"),
    _c("larger", "View", "Larger lobes", "]", "Halve the intensity of a full lobe"),
    _c("smaller", "View", "Smaller lobes", "[", "Double the intensity of a full lobe"),
    _c("fit_scale", "View", "Fit scale", "A", "Let the scale follow the brightest light"),
    _c("heat", "View", "Heat map", "H", "Flux as colours: off, under the lobes, instead of them"),
    _c(
        "overlay", "View", "Overlay", "O", "Exact answer and kept runs in the cells", checkable=True
    ),
    *(
        _c("layer", "View", text, key, f"Show or hide: {text.lower()}", checkable=True, argument=n)
        for (n, text), key in zip(LAYERS.items(), ("Ctrl+1", "Ctrl+2", "Ctrl+3", "Ctrl+4"))
    ),
    _c("slice_axis", "View", "Next slice axis", "S", "Look at a 3D grid along another axis"),
    _c("slice_up", "View", "Next slice", "PgUp", "The next layer of a 3D grid"),
    _c("slice_down", "View", "Previous slice", "PgDown", "The layer before of a 3D grid"),
    _c("level", "View", "Next level", "V", "Levels of an octree, finest first, then all merged"),
    _c("theme", "View", "Light or dark", "Ctrl+D"),
    _c("reset_layout", "View", "Reset layout", "", "Docks where they were at first"),
    _c("palette", "Help", "Command palette", "Ctrl+Shift+P", "Find a command by its name"),
    _c("shortcuts", "Help", "Shortcuts", "? F1", "All keys"),
    _c("about", "Help", "About flatland"),
)
MENUS = ("File", "Edit", "Run", "Tools", "View", "Help")

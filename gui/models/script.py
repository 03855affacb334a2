"""The same from a script: the command that gives the numbers on show."""

from __future__ import annotations

import shlex

from gui.models.choice import Choice
from gui.models.document import SceneDocument
from gui.models.frame import Frame


def command_line(document: SceneDocument, choice: Choice, frame: Frame | None) -> str:
    """`flatland run ...` for a scene, a method and where its run stands.

    The scene's text goes before it if no file has it.
    """
    name = document.command_name
    words = ["flatland", "run", name or "scene.toml", *choice.arguments()]
    if choice.steps:
        if frame is not None and frame.converged is not None:
            words += ["--converge", f"{frame.converged.tolerance:g}"]
        else:
            words += ["--iterations", str(frame.iteration if frame else 0)]
    line = shlex.join(words)
    if name is not None:
        return line
    return f"cat > scene.toml <<'SCENE'\n{document.text.rstrip()}\nSCENE\n{line}"

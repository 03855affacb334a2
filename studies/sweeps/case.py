"""One case of a study: what to compute, as plain values, and the key that names it."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from studies.sweeps.code import code_version
from studies.sweeps.scenes import StudyScene


@dataclass(frozen=True)
class Case:
    """A kind of work with its parameters, on a scene if it needs one.

    parameters: numbers, texts, lists and tables only; they travel to workers and into files.
    timed: whether it must have the machine to itself.
    """

    kind: str
    parameters: Mapping[str, Any] = field(default_factory=dict)
    scene: StudyScene | None = None
    timed: bool = False

    @cached_property
    def key(self) -> str:
        """SHA-256 over kind, parameters, the scene's content and the code version, 20 digits.

        Two cases with one key are one case: what they would compute is the same.
        """
        content = {
            "kind": self.kind,
            "parameters": dict(self.parameters),
            "scene": self.scene.digest if self.scene else None,
            "code": code_version(),
        }
        return hashlib.sha256(canonical(content).encode()).hexdigest()[:20]

    @property
    def label(self) -> str:
        """A short name for people, for messages and lists of failures."""
        values = self.parameters
        parts = [f"{self.kind}: {values.get('propagator', '')}"]
        parts += [f"{values['bands']} bands"] if "bands" in values else []
        parts += [f"on {self.scene.name}"] if self.scene else []
        if self.scene and self.scene.resolution > 1:
            parts.append(f"resolution {self.scene.resolution}")
        return f"{', '.join(parts)} ({self.key})"

    def as_dict(self) -> dict[str, Any]:
        """All that a worker needs."""
        return {
            "kind": self.kind,
            "parameters": dict(self.parameters),
            "scene": self.scene.as_dict() if self.scene else None,
            "timed": self.timed,
        }

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Case:
        scene = StudyScene(**values["scene"]) if values["scene"] else None
        return cls(values["kind"], values["parameters"], scene, values["timed"])


def canonical(value: Any) -> str:
    """JSON with one spelling for equal values."""
    return json.dumps(value, sort_keys=True, separators=(",", ":"), default=list)

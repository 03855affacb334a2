"""Scenes: validated descriptions of grid, lights and occluders; TOML in and out."""

from flatland.scene.catalogue import builtin_names, builtin_text
from flatland.scene.loading import load_scene, parse_scene
from flatland.scene.model import GridTable, Scene
from flatland.scene.problems import Problem, SceneError
from flatland.scene.refinement import refined
from flatland.scene.template import scene_template
from flatland.scene.writing import scene_to_toml

__all__ = [
    "GridTable",
    "Problem",
    "Scene",
    "SceneError",
    "builtin_names",
    "builtin_text",
    "load_scene",
    "parse_scene",
    "refined",
    "scene_template",
    "scene_to_toml",
]

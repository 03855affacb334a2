"""Meshes in files that several tests share."""

import numpy as np
import pytest
import trimesh

from flatland.scene import Scene

BOX = trimesh.creation.box(extents=(1, 2, 3))
BALL = trimesh.creation.icosphere(subdivisions=2)
RING = trimesh.creation.torus(1.0, 0.4, major_sections=12, minor_sections=7)
FORMATS = {
    "a.stl": {"file_type": "stl"},
    "text.stl": {"file_type": "stl_ascii"},
    "a.obj": {"file_type": "obj"},
    "a.OBJ": {"file_type": "obj"},
    "a.ply": {"file_type": "ply"},
    "text.ply": {"file_type": "ply", "encoding": "ascii"},
    "a.off": {"file_type": "off"},
}
every_format = pytest.mark.parametrize("name", FORMATS)


def exported(mesh, name):
    content = mesh.export(**FORMATS[name])
    return content.encode() if isinstance(content, str) else content


def table(name, **keys):
    return {"kind": "mesh", "file": name, **keys}


def scene_with(directory, *tables):
    data = {"grid": {"shape": [4, 4, 4]}, "occluder": list(tables)}
    return Scene.from_dict(data, directory=directory)


def facets(directory, name, content, **keys):
    if isinstance(content, trimesh.Trimesh):
        content = exported(content, name)
    (directory / name).write_bytes(content.encode() if isinstance(content, str) else content)
    return scene_with(directory, table(name, **keys)).facets()


def volume(walls):
    """Of closed surfaces with outward normals; negative if they point inwards."""
    return sum(np.linalg.det(wall.vertices) for wall in walls) / 6


def off(points, *faces):
    rows = [" ".join(map(str, row)) for row in (*points, *((len(f), *f) for f in faces))]
    return "\n".join(["OFF", f"{len(points)} {len(faces)} 0", *rows, ""])

"""Light from data files: what is read, and what is refused."""

import contextlib
import io
import zipfile

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from flatland.errors import InputError
from flatland.harmonics import basis_for
from flatland.injection import inject
from flatland.scene import Scene, SceneError, parse_scene, scene_to_toml

SHAPE = (4, 3)
DATA = np.random.default_rng(1).normal(size=(5, *SHAPE)) * (np.arange(12).reshape(SHAPE) % 3 == 0)


def scene_with(name, directory, shape=SHAPE, **keys):
    tables = {"grid": {"shape": shape}, "light": [{"kind": "file", "file": name, **keys}]}
    return Scene.from_dict(tables, directory=directory)


@pytest.mark.parametrize("name", ["light.npy", "light.npz"])
def test_file_gives_its_coefficients(tmp_path, name):
    if name.endswith("npy"):
        np.save(tmp_path / name, DATA)
    else:
        np.savez_compressed(tmp_path / name, coefficients=DATA)
    scene = scene_with(name, tmp_path, multiplier=2.0)
    np.testing.assert_array_equal(inject(scene, basis_for(2, 3)).values, 2 * DATA)


@pytest.mark.parametrize("bands", [1, 2, 5])
def test_bands_are_dropped_or_zero(tmp_path, bands):
    np.save(tmp_path / "light.npy", DATA)
    field = inject(scene_with("light.npy", tmp_path), basis_for(2, 3)).with_bands(bands)
    found = inject(scene_with("light.npy", tmp_path), basis_for(2, bands))
    np.testing.assert_array_equal(found.values, field.values)


def test_whole_numbers_and_3d_are_read(tmp_path):
    data = np.arange(4 * 2 * 3 * 2).reshape(4, 2, 3, 2)
    np.save(tmp_path / "light.npy", data)
    scene = scene_with("light.npy", tmp_path, shape=(2, 3, 2))
    np.testing.assert_array_equal(inject(scene, basis_for(3, 2)).values, data)


def test_every_lit_cell_has_one_exact_twin(tmp_path):
    np.save(tmp_path / "light.npy", DATA)
    scene = scene_with("light.npy", tmp_path, multiplier=[1.0, 3.0])
    rebuilt = np.zeros((2, *DATA.shape))
    for source in scene.sources():
        i, j = np.floor(source.position).astype(int)
        rebuilt[:, :, i, j] += source.spectrum[:, None] * source.coefficients
    np.testing.assert_array_equal(rebuilt, inject(scene, basis_for(2, 3)).values)


def test_scene_is_equal_only_if_the_data_are(tmp_path):
    np.save(tmp_path / "light.npy", DATA)
    scene = scene_with("light.npy", tmp_path)
    assert parse_scene(scene_to_toml(scene), directory=tmp_path) == scene
    np.save(tmp_path / "light.npy", 2 * DATA)
    assert parse_scene(scene_to_toml(scene), directory=tmp_path) != scene


def saved(**arrays):
    buffer = io.BytesIO()
    np.savez(buffer, **arrays)
    return buffer.getvalue()


def npy(array):
    buffer = io.BytesIO()
    np.save(buffer, array)
    return buffer.getvalue()


def with_shape(shape, kind="<f8"):
    """An .npy file that claims a shape it has no data for."""
    buffer = io.BytesIO()
    header = {"descr": kind, "fortran_order": False, "shape": shape}
    np.lib.format.write_array_header_1_0(buffer, header)
    return buffer.getvalue()


def zipped(name, content):
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr(name, content)
    return buffer.getvalue()


BAD_FILES = {
    "empty": ("a.npy", b"", "cannot be read"),
    "text": ("a.npy", b"hello, world", "cannot be read"),
    "cut short": ("a.npy", npy(DATA)[:-9], "cannot be read"),
    "claims what it lacks": ("a.npy", with_shape((99999999999, 4, 3)), "memory"),
    "truncated header": ("a.npy", npy(DATA)[:30], "cannot be read"),
    "not a zip archive": ("a.npz", npy(DATA), "cannot be read"),
    "damaged zip archive": ("a.npz", saved(coefficients=DATA)[:-100], "cannot be read"),
    "another name": ("a.npz", saved(data=DATA), "no array named 'coefficients'"),
    "no array in the archive": ("a.npz", zipped("coefficients.npy", b"abc"), "cannot be read"),
    "even number of coefficients": ("a.npy", npy(DATA[:4]), "2 n - 1"),
    "another grid": ("a.npy", npy(DATA[:, :, :2]), "shape"),
    "a single number": ("a.npy", npy(np.float64(1)), "shape"),
    "not finite": ("a.npy", npy(np.where(DATA == 0, np.nan, DATA)), "not finite"),
    "complex numbers": ("a.npy", npy(DATA * 1j), "real numbers"),
    "text in the array": ("a.npy", npy(DATA.astype(str)), "real numbers"),
    "pickled objects": ("a.npy", npy(DATA.astype(object)), "real numbers"),
}


@pytest.mark.parametrize(("name", "content", "rule"), BAD_FILES.values(), ids=BAD_FILES)
def test_bad_file_is_refused(tmp_path, name, content, rule):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=rf"light 1, file = '{name}': .*{rule}"):
        scene_with(name, tmp_path)


@pytest.mark.parametrize("name", ["none.npy", "folder.npz", "../none.npy"])
def test_missing_file_is_refused(tmp_path, name):
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(SceneError, match="is not a file"):
        scene_with(name, tmp_path)


@pytest.mark.parametrize("name", ["", "light.txt", "a\0.npy", 5])
def test_name_that_is_no_data_file_is_refused(tmp_path, name):
    with pytest.raises(SceneError, match="light 1, file"):
        scene_with(name, tmp_path)


@settings(
    deadline=None,
    derandomize=True,
    max_examples=150,
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)
@given(st.sampled_from([("a.npy", npy(DATA)), ("a.npz", saved(coefficients=DATA))]), st.data())
def test_damage_anywhere_is_an_input_error_or_harmless(tmp_path, file, data):
    name, content = file
    damaged = bytearray(content)
    damaged[data.draw(st.integers(0, len(content) - 1))] = data.draw(st.integers(0, 255))
    (tmp_path / name).write_bytes(damaged)
    with contextlib.suppress(InputError):
        scene_with(name, tmp_path)

"""Arrays of other libraries by DLPack, in and out, without a copy.

A plain class that knows nothing but DLPack's two methods is always tested; PyTorch and JAX where
they are installed.
"""

import importlib

import numpy as np
import pytest

import omma
from omma.base.arrays import new_floats
from omma.base.poses import as_poses


class Foreign:
    """Another library's array: only what DLPack asks for, around NumPy's."""

    def __init__(self, array, versioned=True, device=1):
        self.array, self.versioned, self.device = array, versioned, device

    def __dlpack__(self, **asked):
        return self.array.__dlpack__(**asked) if self.versioned else self.array.__dlpack__()

    def __dlpack_device__(self):
        return (self.device, 0)


class OldForeign(Foreign):
    """One from before DLPack told what may be written to, which NumPy can read by itself too."""

    def __init__(self, array):
        super().__init__(array, versioned=False)

    def __array__(self, dtype=None, copy=None):
        return self.array


@pytest.fixture(scope="module")
def poses(flight):
    return np.ascontiguousarray(flight)


def test_poses_are_taken_as_they_lie(poses):
    assert np.shares_memory(as_poses(Foreign(poses)), poses)
    assert np.shares_memory(as_poses(Foreign(poses[0])), poses)
    assert np.shares_memory(as_poses(OldForeign(poses)), poses)
    # What does not fit is copied: float32, and matrices that lie the other way round.
    for other in (poses.astype(np.float32), np.asfortranarray(poses)):
        taken = as_poses(Foreign(other))
        assert not np.shares_memory(taken, other)
        assert (taken == other).all()


def test_renders_of_them_are_the_same(renderer, poses):
    expected = renderer.render(poses)
    assert (renderer.render(Foreign(poses)) == expected).all()
    frozen = poses.copy()
    frozen.flags.writeable = False
    assert (renderer.render(frozen) == expected).all()
    assert (np.stack(list(renderer.render_iter(Foreign(poses)))) == expected).all()
    positions, quaternions = poses[:, :3, 3], np.tile([0.0, 0, 0, 1], (len(poses), 1))
    by_pair = renderer.render((Foreign(positions), Foreign(quaternions)))
    assert (by_pair == renderer.render((positions, quaternions))).all()


@pytest.mark.parametrize("kind", [Foreign, OldForeign])
def test_responses_are_written_where_they_are_wanted(renderer, poses, kind):
    mine = np.full((len(poses), len(renderer.eye), 3), -1, np.float32)
    given = renderer.render(poses, out=kind(mine))
    assert np.shares_memory(given, mine)
    assert (mine == renderer.render(poses)).all()


@pytest.mark.parametrize("shape", [(1, 1), (3, 5, 3), (700, 1001)])
def test_arrays_begin_where_jax_takes_them(shape):
    """At a multiple of 64 bytes; NumPy's own begin 16 or 32 behind one."""
    found = [new_floats(shape) for _ in range(5)]
    assert all(one.ctypes.data % 64 == 0 and one.flags.c_contiguous for one in found)
    assert {one.shape for one in found} == {shape}


def test_out_that_does_not_do_is_refused(renderer, poses):
    shape = (len(poses), len(renderer.eye), 3)
    locked = np.zeros(shape, np.float32)
    locked.flags.writeable = False
    with pytest.raises(omma.Error, match=r"out: .* can be written to, found .* read-only"):
        renderer.render(poses, out=Foreign(locked))
    with pytest.raises(omma.Error, match=r"out: .* can be written to, found .* read-only"):
        # Nobody says that it may be written to.
        renderer.render(poses, out=Foreign(np.zeros(shape, np.float32), versioned=False))
    with pytest.raises(TypeError, match="out: expected a float32 array"):
        renderer.render(poses, out=Foreign(np.zeros(shape)))
    with pytest.raises(omma.Error, match="out: expected shape"):
        renderer.render(poses, out=Foreign(np.zeros((1, 2, 3), np.float32)))


def test_another_device_is_refused_by_name(renderer, poses):
    cuda = Foreign(poses, device=2)
    with pytest.raises(omma.Error, match="poses: expected an array in the memory of the CPU"):
        renderer.render(cuda)
    out = Foreign(np.zeros((len(poses), len(renderer.eye), 3), np.float32), device=2)
    with pytest.raises(omma.Error, match="out: expected an array in the memory of the CPU"):
        renderer.render(poses, out=out)
    with pytest.raises(omma.Error, match="positions_m: expected an array in the memory of the CPU"):
        omma.poses_from_angles(Foreign(np.zeros((1, 3)), device=10), [[0, 0, 0]])


def test_what_cannot_be_handed_over_says_why(renderer):
    class Broken(Foreign):
        def __dlpack__(self, **asked):
            raise BufferError("tensors that require a gradient are not exported\nmore")

    class Nowhere(Foreign):
        """As PyTorch's on the device "meta"."""

        def __dlpack_device__(self):
            raise ValueError("Unknown device type")

    with pytest.raises(omma.Error, match="found test_dlpack's Broken: tensors that require a gr"):
        renderer.render(Broken(np.eye(4)))
    for call in (
        lambda: renderer.render(Nowhere(np.eye(4))),
        lambda: renderer.render(np.eye(4), out=Nowhere(np.eye(4))),
    ):
        with pytest.raises(omma.Error, match="found test_dlpack's Nowhere: Unknown device type"):
            call()


def library(name, request):
    """The library's ways (array from NumPy's without a copy, array from whatever has DLPack)."""
    module = pytest.importorskip(name)
    if name == "torch":
        return module.from_numpy, module.from_dlpack
    module.config.update("jax_enable_x64", True)
    request.addfinalizer(lambda: module.config.update("jax_enable_x64", False))
    from_dlpack = importlib.import_module("jax.dlpack").from_dlpack
    return from_dlpack, from_dlpack


@pytest.mark.parametrize("name", ["torch", "jax"])
def test_with_other_libraries(renderer, poses, name, request):
    from_numpy, from_dlpack = library(name, request)
    theirs = from_numpy(poses)
    taken = as_poses(theirs)
    address = theirs.data_ptr() if name == "torch" else theirs.unsafe_buffer_pointer()
    assert taken.ctypes.data == address
    responses = renderer.render(theirs)
    assert (responses == renderer.render(poses)).all()
    # Out: the same memory, seen by the other library.
    out = from_dlpack(responses)
    address = out.data_ptr() if name == "torch" else out.unsafe_buffer_pointer()
    assert responses.ctypes.data == address
    assert (np.asarray(out) == responses).all()


def test_torch_tensors_are_written_to(renderer, poses):
    torch = pytest.importorskip("torch")
    mine = torch.zeros((len(poses), len(renderer.eye), 3))
    given = renderer.render(poses, out=mine)
    assert given.ctypes.data == mine.data_ptr()
    assert (mine.numpy() == renderer.render(poses)).all()
    with pytest.raises(omma.Error, match="poses: expected an array that DLPack can hand over"):
        renderer.render(torch.eye(4, dtype=torch.float64, requires_grad=True))


def test_arrays_of_jax_are_not_written_to(renderer, poses):
    """They never change, as JAX takes for granted."""
    jnp = pytest.importorskip("jax.numpy")
    mine = jnp.zeros((len(poses), len(renderer.eye), 3), np.float32)
    with pytest.raises(omma.Error, match=r"out: .* can be written to, found .* arrays of JAX"):
        renderer.render(poses, out=mine)

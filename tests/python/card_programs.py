"""What `test_card_arrays` runs, each in a program of its own that has the tests' stand-in for a
graphics card, as a card is of a process."""

import ctypes
import gc
import os

import numpy as np
import pytest

import omma
from omma import _core
from omma.base.card_arrays import find_on_card
from omma.rendering import CardArray

STREAM = 0x1230


class Tensor:
    """Another library's array on the card: only what ``__cuda_array_interface__`` asks for."""

    def __init__(self, array, version=2, read_only=False, card=0, **more):
        self.memory = _core.CardMemory(array.nbytes // 4 + 1, card)
        numbers = np.ascontiguousarray(array).reshape(-1)
        _core.card_write(card, self.memory.at, numbers.view(np.uint8))
        self.given = {
            "version": version,
            "shape": array.shape,
            "typestr": array.dtype.str,
            "data": (self.memory.at, read_only),
            **more,
        }

    @property
    def __cuda_array_interface__(self):
        return self.given

    def numpy(self):
        return find_on_card(self, "tensor").copy()


class Turning(Tensor):
    """One that has a gradient, which PyTorch does not hand over."""

    @property
    def __cuda_array_interface__(self):
        raise RuntimeError("Can't get __cuda_array_interface__ on Variable that requires grad.")


def driver():
    """The stand-in itself."""
    library = ctypes.CDLL(os.environ["OMMA_CUDA_DRIVER"])
    library.emulated_last_stream.restype = ctypes.c_void_p
    return library


def scene():
    return omma.load_scene(omma.examples.meadow())


def renderer(backend="cuda", sampling=None, eye=None, devices=(), **settings):
    world = omma.World(scene(), backend=backend, devices=devices)
    return omma.Renderer(
        world, eye or omma.eye.generate_eye(60), sampling or omma.Fixed(2), **settings
    )


POSES = np.stack([omma.look_at((0.1, 0.3, 2 - t), (2, 0.2, -5)) for t in (0, 0.1, 0.2)])


def responses_stay_there():
    """Whether kernels write them or, where the host sums up, they are copied there."""
    for backend in ("cuda", "portable"):
        for sampling in (omma.Fixed(2), omma.ToError(0.1, 4, 64), omma.Shared(2)):
            one = renderer(backend, sampling)
            expected, errors = one.render(POSES, standard_error=True)
            out, error_out = CardArray(expected.shape), Tensor(np.zeros_like(expected))
            given = one.render(POSES, standard_error=True, out=out, error_out=error_out)
            assert given[0] is out
            assert given[1] is error_out
            assert np.array_equal(out.numpy(), expected)
            assert np.array_equal(error_out.numpy(), errors)
            # Errors that nobody wants there come as NumPy's.
            assert np.array_equal(one.render(POSES, standard_error=True, out=out)[1], errors)
            tensor = Tensor(np.zeros_like(expected))
            assert one.render(POSES, out=tensor) is tensor
            assert np.array_equal(tensor.numpy(), one.render(POSES))
    to_error = renderer(sampling=omma.ToError(0.1, 4, 64))
    expected, report = to_error.render(POSES, report=True)
    given, same = to_error.render(POSES, report=True, out=out)
    assert np.array_equal(given.numpy(), expected)
    assert same == report


def every_card_has_its_own():
    """What one card has written for a tensor on another is copied there, as is what two share."""
    expected = renderer().render(POSES)
    for devices in ((0,), (1,), (0, 1)):
        one = renderer(devices=devices)
        for card in (0, 1):
            out = CardArray(expected.shape, card)
            one.render(POSES, out=out)
            assert np.array_equal(out.numpy(), expected)
            assert out.__dlpack_device__() == (2, card)
    with pytest.raises(omma.Error, match="devices: expected ordinals below 2"):
        CardArray((3,), 2)


def responses_of_what_lasts_and_moves_stay_there():
    one = renderer(impulse_response=omma.photoreceptors.ImpulseResponse.howard(0.01, 0.3))
    there = np.tile(one.world.instances[0].world_from_node, (len(POSES), 1, 1, 1))
    there[:, 0, 1, 3] += [0, 0.1, 0.2]
    still = {"times_s": 0.01 * np.arange(3)}
    moving = {**still, "instances": [0], "transforms": there}
    for moves in (still, moving):
        expected = one.render(POSES, **moves)
        out = CardArray(expected.shape)
        one.render(POSES, **moves, out=out)
        assert np.array_equal(out.numpy(), expected)


def receptors_stay_there():
    eye = omma.species.drosophila().eye
    one = renderer(eye=eye)
    expected = one.render_receptors(POSES, ultraviolet="dark")
    out = CardArray(expected.shape)
    assert one.render_receptors(POSES, ultraviolet="dark", out=out) is out
    assert np.array_equal(out.numpy(), expected)


def poses_come_from_there():
    one = renderer()
    expected = one.render(POSES)
    for array in (POSES, np.float32(POSES)):
        assert np.array_equal(one.render(Tensor(array)), one.render(array))
    positions, turns = POSES[:, :3, 3], np.tile([0.0, 0, 0, 1], (len(POSES), 1))
    by_pair = one.render((Tensor(positions), Tensor(turns)))
    assert np.array_equal(by_pair, one.render((positions, turns)))
    assert not np.array_equal(expected, by_pair)
    # Also to a processor, and so do transforms.
    world = omma.World(scene(), backend="portable")
    there = world.instances[0].world_from_node.copy()
    there[1, 3] += 0.5
    world.set_transforms([0], Tensor(there[None]))
    assert np.array_equal(world.instances[0].world_from_node, there)


def streams_are_kept():
    """Kernels run where the tensor's library says; where it does not say, all is waited for."""
    one, card = renderer(), driver()
    expected = one.render(POSES)
    assert not card.emulated_last_stream()
    tensor = Tensor(np.zeros_like(expected), version=3, stream=STREAM)
    one.render(POSES, out=tensor)
    assert card.emulated_last_stream() == STREAM
    assert np.array_equal(tensor.numpy(), expected)
    one.render(POSES)
    assert not card.emulated_last_stream()
    # Of two streams one is used, and the other waited for.
    other = Tensor(np.zeros_like(expected), version=3, stream=STREAM + 16)
    card.emulated_fail(b"cuCtxSynchronize", 719, 1, -1)
    with pytest.raises(omma.Error, match=r"cuda:0 .*cuCtxSynchronize failed"):
        one.render(POSES, standard_error=True, out=tensor, error_out=other)
    unsaid = Tensor(np.zeros_like(expected), version=2)
    card.emulated_fail(b"cuCtxSynchronize", 719, 1, -1)
    with pytest.raises(omma.Error, match=r"cuda:0 .*cuCtxSynchronize failed"):
        one.render(POSES, out=unsaid)


def bad_arrays_are_refused_by_name():
    one = renderer()
    shape = one.render(POSES).shape
    zeros = np.zeros(shape, np.float32)
    refused = [
        (Tensor(np.zeros((1, 2, 3), np.float32)), omma.Error, "out: expected shape"),
        (Tensor(np.zeros(shape)), TypeError, "out: expected a float32 array"),
        (Tensor(zeros, read_only=True), omma.Error, "out: expected an array that can be written"),
        (Tensor(zeros, strides=(4, 12, 4)), omma.Error, "out: expected an array in C order"),
        (Tensor(zeros, mask=zeros), omma.Error, "out: expected an array of numbers"),
        (Turning(zeros), omma.Error, "out: expected an array that its library hands over"),
    ]
    elsewhere = Tensor(zeros)
    elsewhere.given["data"] = (zeros.ctypes.data, False)
    refused.append((elsewhere, omma.Error, "out: expected an array on a card, found one that the"))
    for out, error, words in refused:
        with pytest.raises(error, match=words):
            one.render(POSES, out=out)
    without = Tensor(zeros)
    del without.given["typestr"]
    with pytest.raises(omma.Error, match="out: expected __cuda_array_interface__ with shape"):
        one.render(POSES, out=without)
    both = CardArray(shape)
    with pytest.raises(omma.Error, match="error_out: shares memory with out"):
        one.render(POSES, standard_error=True, out=both, error_out=both)
    with pytest.raises(omma.Error, match="poses: expected an array in C order"):
        one.render(Tensor(POSES, strides=(8, 8, 8)))
    with pytest.raises(omma.Error, match="shape: expected 1 to"):
        CardArray((0, 3))
    with pytest.raises(omma.Error, match=r"expected .* MB of memory, found .* free"):
        CardArray((1 << 20, 1 << 20))


def memory_is_given_back():
    """More in all than the card has, and what worlds had left there goes first."""
    one = renderer()
    expected = one.render(POSES)
    for _ in range(100):
        out = CardArray((1 << 26,))  # 268 MB
        del out
        gc.collect()
    assert np.array_equal(one.render(POSES), expected)


class Tensors(ctypes.Structure):
    """DLManagedTensor (dmlc.github.io/dlpack/latest/c_api.html), as far as it is read."""

    _fields_ = [
        ("data", ctypes.c_void_p),
        ("device_type", ctypes.c_int32),
        ("device", ctypes.c_int32),
        ("axes", ctypes.c_int32),
        ("type", ctypes.c_uint8 * 4),
        ("shape", ctypes.POINTER(ctypes.c_int64)),
        ("strides", ctypes.POINTER(ctypes.c_int64)),
    ]


def dlpack_hands_them_over():
    array = CardArray((2, 3, 4))
    assert array.__dlpack_device__() == (2, 0)
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    capsule = array.__dlpack__()
    tensor = Tensors.from_address(pointer(capsule, b"dltensor"))
    assert tensor.data == array.__cuda_array_interface__["data"][0]
    assert (tensor.device_type, tensor.device, tensor.axes) == (2, 0, 3)
    assert tensor.shape[:3] == [2, 3, 4]
    assert list(tensor.type) == [2, 32, 1, 0]  # float, of 32 bits, one of them
    # The memory lives as long as whoever has taken it.
    at = array.__cuda_array_interface__["data"][0]
    del array
    gc.collect()
    assert find_on_card(CardArray((24,)), "array").at != at

"""Options of rays are declared once; everything that takes or tells them follows from that."""

import inspect
import json
import pickle
import re
from dataclasses import FrozenInstanceError, fields, replace
from typing import get_args, get_type_hints

import numpy as np
import pytest

import omma
from omma.job.all_cameras import render_all_cameras
from omma.job.render_job import JobOptions, RenderJob
from omma.rendering import Settings
from omma.rendering.settings import (
    Options,
    Sampling,
    options_of,
    settings_as_record,
    settings_from_record,
)

EVERY = [
    Settings(),
    Settings(omma.Fixed(3), seed=2**64 - 1, angular_sensitivity="pillbox", points="random"),
    Settings(omma.ToError(0.01), footprints=False),
    Settings(omma.ToError(0.1, least=4, most=99), noise="new_every_frame"),
    Settings(omma.Shared(7), angular_sensitivity="gaussian"),
]


def test_type_checkers_see_every_option():
    declared = {name: kind for name, kind in get_type_hints(Settings).items() if name != "sampling"}
    assert get_type_hints(Options) == declared


def test_type_checkers_see_every_field_of_a_job():
    first = ("scene", "outputs", "settings")
    declared = {name: kind for name, kind in get_type_hints(RenderJob).items() if name not in first}
    assert get_type_hints(JobOptions) == get_type_hints(Options) | declared


def test_render_file_takes_and_explains_every_field_of_a_job():
    parameters = inspect.signature(omma.render_file).parameters
    explained = re.findall(r"^    (\w+(?:, \w+)*): ", inspect.getdoc(omma.render_file), re.M)
    names = {name for line in explained for name in line.split(", ")}
    for one in fields(RenderJob)[3:]:
        assert parameters[one.name].default == one.default
        assert one.name in names


def test_jobs_are_values():
    job = RenderJob("a.glb", "a.npy", Settings(), poses=np.eye(4), light="lamps")
    assert pickle.loads(pickle.dumps(job)) == job
    assert replace(job, light=None) != job
    assert replace(job, poses=2 * np.eye(4)) != job
    with pytest.raises(omma.Error, match="path and poses: only one of them"):
        replace(job, path="a.csv")
    with pytest.raises(FrozenInstanceError):
        job.gamma = 2


@pytest.mark.parametrize("function", [omma.Renderer, omma.render_file, render_all_cameras])
def test_signatures_have_every_option(function):
    parameters = inspect.signature(function).parameters
    assert parameters["sampling"].default == Settings.sampling
    for option in options_of(Settings):
        assert parameters[option.name].default == option.default
    assert inspect.Parameter.VAR_KEYWORD not in {one.kind for one in parameters.values()}


def test_changed_options_are_those_that_there_are(scene, eye):
    """What is not given stays as it was, which no default says."""
    parameters = inspect.signature(omma.Renderer.with_eye).parameters
    assert all(parameters[option.name].default is None for option in options_of(Settings))
    assert inspect.Parameter.VAR_KEYWORD not in {one.kind for one in parameters.values()}
    renderer = omma.Renderer(scene, eye, omma.Fixed(1), seed=5, footprints=False)
    assert renderer.with_eye(eye, seed=6).settings == replace(renderer.settings, seed=6)
    with pytest.raises(TypeError, match=r"Renderer.with_eye: .*'samples'; did you mean 'sampling'"):
        renderer.with_eye(eye, samples=omma.Fixed(64))


def test_help_tells_every_option(run_omma):
    _, said, _ = run_omma("render", "--help")
    for kind in (*get_args(Sampling), Settings):
        for option in options_of(kind):
            assert f"{option.name}: {option.metadata['help']}" in kind.__doc__
    for name in ("samples", "error", "least", "most", "shared", "no-footprints"):
        assert f"--{name}" in said
    for option in options_of(Settings):
        assert f"--{option.name.replace('_', '-')}" in said


@pytest.mark.parametrize("settings", EVERY)
def test_values(settings):
    assert pickle.loads(pickle.dumps(settings)) == settings
    assert hash(settings) == hash(pickle.loads(pickle.dumps(settings)))
    assert eval(repr(settings), {"Settings": Settings, **vars(omma)}, vars(omma)) == settings
    record = settings_as_record(settings)
    assert settings_from_record(json.loads(json.dumps(record))) == settings
    assert settings_from_record({**record, "something": "else"}) == settings


def test_numbers_are_kept_as_plain_ones():
    settings = Settings(omma.Fixed(np.int64(4)), seed=np.uint64(2**63), footprints=np.True_)
    assert settings.footprints is True
    assert settings == Settings(omma.Fixed(4), seed=2**63)
    assert type(settings.sampling.samples) is type(settings.seed) is int
    assert type(omma.ToError(np.float32(0.5)).error) is float


def test_a_record_of_something_else_is_refused():
    with pytest.raises(omma.Error, match=r"^sampling: expected one of Fixed, ToError, Shared"):
        settings_from_record(settings_as_record(Settings()) | {"sampling": "Fixd"})
    for wrong in ({"sampling": "Fixed"}, settings_as_record(Settings()) | {"seed": "many"}):
        with pytest.raises(omma.Error, match=r"^settings: expected those of a render"):
            settings_from_record(wrong)


OLD_NAME = "kernel: is called angular_sensitivity now"


def test_the_old_name_of_angular_sensitivity(scene, eye):
    with pytest.warns(DeprecationWarning, match=OLD_NAME):
        settings = Settings(kernel="pillbox")
    assert settings == Settings(angular_sensitivity="pillbox")
    with pytest.warns(DeprecationWarning, match=OLD_NAME) as told:
        renderer = omma.Renderer(scene, eye, omma.Fixed(1), kernel="pillbox")
    assert [one.filename for one in told] == [__file__]
    assert renderer.settings == replace(settings, sampling=omma.Fixed(1))
    with pytest.warns(DeprecationWarning, match=OLD_NAME):
        assert renderer.with_eye(eye, kernel="own").settings.angular_sensitivity == "own"
    with pytest.warns(DeprecationWarning, match=OLD_NAME):
        assert settings.kernel == "pillbox"
    with pytest.warns(DeprecationWarning, match=OLD_NAME):
        assert omma.study.Method(kernel="pillbox") == omma.study.Method("pillbox")
    with (
        pytest.warns(DeprecationWarning, match=OLD_NAME),
        pytest.raises(TypeError, match=r"^angular_sensitivity: given twice, as kernel too"),
    ):
        Settings(angular_sensitivity="own", kernel="own")


def test_records_with_the_old_name():
    settings = Settings(angular_sensitivity="pillbox")
    record = settings_as_record(settings)
    record["kernel"] = record.pop("angular_sensitivity")
    assert settings_from_record(record) == settings

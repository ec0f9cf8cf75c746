"""Responses as an `xarray.Dataset`: with their coordinates, their units and what they were made of.

Needs xarray, an optional extra, which is imported only here and only when a dataset is made.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from omma._core import Error
from omma.base.arguments import array_of
from omma.rendering.labels import Labels, labels_of
from omma.rendering.moves import MovesOptions
from omma.rendering.settings import ToError
from omma.rendering.truth import GroundTruth, check_truth, truth_variables

if TYPE_CHECKING:
    import xarray

    from omma.rendering.renderer import Poses, Progress, Renderer


def make_dataset(
    renderer: Renderer,
    poses: Poses,
    *,
    receptors: bool,
    ultraviolet: ArrayLike | None,
    standard_error: bool,
    time_s: ArrayLike | None,
    truth: GroundTruth | None,
    first_pose: int | None,
    progress: Progress | None,
    moves: MovesOptions,
) -> xarray.Dataset:
    """What `Renderer.dataset` does, whose arguments these are."""
    load_xarray()
    if ultraviolet is not None and not receptors:
        raise Error("ultraviolet: is for receptors=True")
    matrices = renderer._matrices(poses)
    if time_s is None:
        time_s = moves.get("times_s")
    times = None if time_s is None else array_of(time_s, "time_s", (len(matrices),))
    options: dict[str, Any] = {"first_pose": first_pose, "progress": progress, **moves}
    rays = errors = None
    found: Any
    if truth is not None:
        if receptors or standard_error:
            raise Error("truth: not together with receptors or standard_error")
        check_truth(truth, (len(matrices), len(renderer.eye), renderer.bands))
        found, errors, rays = truth.responses, truth.standard_error, truth.rays
        standard_error = errors is not None
    elif receptors:
        options |= {"ultraviolet": ultraviolet, "standard_error": standard_error}
        found = renderer.render_receptors(matrices, **options)
    else:
        auto = isinstance(renderer.settings.sampling, ToError)
        options |= {"report": True} if auto else {"standard_error": standard_error}
        found = renderer.render(matrices, **options)
        if auto:
            found, rays, errors = found[0], found[1].rays, found[1].standard_error
    if isinstance(found, tuple):
        found, errors = found
    # Only now that the engine has accepted the poses.
    labels = labels_of(
        renderer, matrices, receptors=receptors, standard_error=standard_error, time_s=times
    )
    data = dataset_of(labels, {"response": found, "standard_error": errors, "rays": rays})
    if truth is None:
        return data
    first = "pose" if times is None else "time"
    with_truth: xarray.Dataset = data.assign(truth_variables(truth, (first, "ommatidium")))
    return with_truth


def dataset_of(labels: Labels, values: dict[str, Any]) -> xarray.Dataset:
    """The dataset of labels and the values of their variables."""
    variables = {
        name: (dimensions, values[name], attributes)
        for name, (dimensions, _, attributes) in labels.variables.items()
    }
    data: xarray.Dataset = load_xarray().Dataset(variables, labels.coordinates, labels.attributes)
    return data


def load_xarray() -> Any:
    """The package xarray; omma.Error where it is not installed."""
    try:
        import xarray
    except ImportError:
        raise Error(
            "datasets need xarray, which is not installed: pip install 'omma[data]'"
        ) from None
    return xarray

"""How a renderer takes its rays: every option is declared here, once.

A field of `Fixed`, `ToError`, `Shared` or `Settings` has its help, its default and its range beside
it. `Renderer`, `render_file`, ``omma render`` and the attributes of written responses follow from
that. A new option is a field here, a line of `Options` for type checkers, and what the engine does
with it (``RenderSettings`` in include/omma/render.h).
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, TypedDict, TypeVar, cast, get_args, get_type_hints

import numpy as np

from omma import _core
from omma._core import Error, RenderSettings
from omma.base.arguments import expect, one_of, positive, whole
from omma.base.notebook import html_table
from omma.base.renamed import renamed_fields
from omma.photoreceptors import ImpulseResponse

MAX_SAMPLES = 1 << 20
_MOST_UNASKED = 4096  # of ToError
# Of ToError with a relative error alone: in the dark what is bright may be met by few rays.
_LEAST_RELATIVE = 32
_DELAYS = 4097  # quantiles of an impulse response that the engine is given

AngularSensitivityName = Literal["own", "gaussian", "pillbox", "compoundray"]
PointsName = Literal["low_discrepancy", "random"]
NoiseName = Literal["frozen", "new_every_frame"]

F = TypeVar("F", bound=Callable[..., Any])


def _option(
    default: Any, text: str, metavar: str = "N", low: int = 1, high: int = MAX_SAMPLES
) -> Any:
    """A field with its help, and the range of whole numbers where it is one."""
    return field(default=default, metadata={"help": text, "metavar": metavar, "range": (low, high)})


def options_of(kind: type) -> list[dataclasses.Field[Any]]:
    """The options that a class of this file declares."""
    return [one for one in dataclasses.fields(kind) if "help" in one.metadata]


def option_types(kind: Any) -> dict[str, Any]:
    """What each option of a class is: int, bool, Literal[...], int | None, ..."""
    return get_type_hints(kind)


def _check(declared: Any) -> None:
    """Check the options of a class of this file; numbers become plain: 16, not numpy.int64(16)."""
    types = option_types(type(declared))
    for one in options_of(type(declared)):
        value, kind = getattr(declared, one.name), types[one.name]
        choices = get_args(kind)
        if value is None and type(None) in choices:
            continue
        if kind is bool:
            if not isinstance(value, (bool, np.bool_)):
                found = f"{type(value).__name__} {value!r:.40}"
                raise TypeError(f"{one.name}: expected True or False, found {found}")
            value = bool(value)
        elif kind is float or float in choices:
            value = positive(value, one.name)
        elif kind is int or int in choices:
            value = whole(value, one.name, *one.metadata["range"])
        else:
            value = one_of(value, choices, one.name)
        object.__setattr__(declared, one.name, value)


@dataclass(frozen=True)
class Fixed:
    """As many rays for every ommatidium. With a standard error, for each of its 8 scrambles."""

    samples: int = _option(16, "Rays per ommatidium, or per pixel of a camera's picture.")

    def __post_init__(self) -> None:
        _check(self)


@dataclass(frozen=True)
class ToError:
    """As many rays as each ommatidium needs for its standard error, as estimated, to be small: a
    radiance, or a fraction of the response itself. With both, the larger of the two.

    Example:
        >>> omma.ToError(0.003).limits()  # rays of an ommatidium, at least and at most
        (32, 4096)
        >>> omma.ToError(relative_error=0.05)  # 5 % of each response, in every band
        ToError(error=None, least=None, most=None, relative_error=0.05)
    """

    error: float | None = _option(
        None,
        "As many rays as each ommatidium needs for its estimated standard error to be this; "
        "a radiance of 1 is full scale.",
        "E",
    )
    least: int | None = _option(
        None,
        "With an error: least rays of an ommatidium, a power of two. Default: 8, and 16 from an "
        "error of 0.006 down, 32 from 0.003, 64 from 0.0015; 32 with a relative error alone.",
        low=4,
    )
    most: int | None = _option(
        None, "With an error: most rays of an ommatidium. Default: 4,096.", low=4
    )
    relative_error: float | None = _option(
        None,
        "An error as a fraction of each response: 0.05 is 5 % of what an ommatidium sees, in the "
        "dark as in the light. With both, the larger counts.",
        "E",
    )

    def __post_init__(self) -> None:
        _check(self)
        if self.error is None and self.relative_error is None:
            raise Error("ToError: expected an error, or a relative_error, found neither")
        if self.relative_error is not None and self.relative_error > 1:
            raise Error(
                "relative_error: expected a fraction of the response, up to 1, "
                f"found {self.relative_error:g}"
            )
        least, most = self.limits()
        if least & (least - 1):
            raise Error(f"least: expected a power of two, found {least}")
        whole(most, "most", least, MAX_SAMPLES)

    def limits(self) -> tuple[int, int]:
        """Rays that an ommatidium gets at least and at most, where not said those that suit."""
        most = self.most or _MOST_UNASKED
        least = self.least
        if least is None and self.error is not None:
            least = _least_samples(self.error, most)
        elif least is None:
            least = min(_LEAST_RELATIVE, 1 << (most.bit_length() - 1))
        return least, self.most or max(_MOST_UNASKED, least)


def _least_samples(error: float, most: int) -> int:
    """Default of `ToError.least`: 8, and from an error of 0.00625 down the power of two below 0.1 /
    error, up to 64.

    Errors that few rays cannot see are missed by their estimate too, and these weigh the more the
    smaller the wanted error is. In the arena 32 instead of 8 rays reduce the worst of 50,000 from
    28 times an error of 0.003 to 4 times, for 7 % more rays (docs/sampling.md).
    """
    least = 8
    while least < 64 and 2 * least * error <= 0.1 and 2 * least <= most:
        least *= 2
    return least


@dataclass(frozen=True)
class Shared:
    """Neighbouring ommatidia share rays: about ``samples`` for each are traced in all, and each
    uses those of its neighbours too.

    Where fields of view overlap as in a honeybee's eye, that is six to seven times fewer rays for
    the same error. What it costs: a ray starts at the ommatidium nearest to its direction, so that
    of things at a distance d an eye of radius of curvature R has an acceptance angle (1 + R/d)
    times as wide; errors of neighbours go together; and the rays are fixed to the head, the same at
    every pose. Ommatidia that would gain nothing trace their own rays;
    `Renderer.shared_ommatidia` says who shares. Not for surfaces within some ten radii, nor with
    random points, the angular sensitivity "compoundray", apertures or sensitivities that are not
    round. See docs/sampling.md.
    """

    samples: int = _option(
        16,
        "Neighbours share rays, about so many per ommatidium in all: far less error. Not for "
        "surfaces within some ten eye radii.",
        high=256,
    )

    def __post_init__(self) -> None:
        _check(self)


Sampling = Fixed | ToError | Shared


@renamed_fields(kernel="angular_sensitivity")
@dataclass(frozen=True)
class Settings:
    """Everything about a renderer's rays that responses depend on.

    impulse_response: how photoreceptors answer a flash (`omma.photoreceptors.ImpulseResponse`):
        each ray draws from it how long before a frame it looks, and starts from where the head was
        then (docs/motion-and-time.md). None: frames are instants.
    """

    sampling: Sampling = Fixed()
    seed: int = _option(
        0,
        "Seed of the samples. The same inputs and seed give the same bits, whatever the number of "
        "threads.",
        low=0,
        high=(1 << 64) - 1,
    )
    angular_sensitivity: AngularSensitivityName = _option(
        "own",
        "Each ommatidium's own angular sensitivity, or one for all with its acceptance angle Δρ, "
        "per unit solid angle: gaussian, exp(-4 ln2 (θ/Δρ)²); pillbox, 1 within Δρ/2; compoundray, "
        "CompoundRay's, a Gaussian over sin θ (eLife 2022, 73893), to compare with work done with "
        "it.",
    )
    points: PointsName = _option(
        "low_discrepancy",
        "Where rays go in a field of view: scrambled Sobol points (Owen 1995), moved apart, or "
        "random ones.",
    )
    footprints: bool = _option(
        True,
        "Rays read textures averaged over their share of the solid angle, so that fine texture "
        "does not become noise; the modulation transfer stays within 0.01 of its own.",
    )
    noise: NoiseName = _option(
        "frozen",
        "Each ommatidium's pattern of rays: the same at all poses and in all frames, so that what "
        "stands still looks still; or another for every frame, so that noise averages out. See "
        "docs/sampling.md.",
    )

    impulse_response: ImpulseResponse | None = None

    def __post_init__(self) -> None:
        if not isinstance(self.sampling, get_args(Sampling)):
            found = f"{type(self.sampling).__name__} {self.sampling!r:.40}"
            raise TypeError(
                f"sampling: expected omma.Fixed, omma.ToError or omma.Shared, found {found}"
            )
        _check(self)
        if isinstance(self.sampling, Shared):
            if self.points == "random":
                raise Error("points: expected low_discrepancy where rays are shared, found random")
            if self.noise != "frozen":
                raise Error(f"noise: expected frozen where rays are shared, found {self.noise}")
        if self.impulse_response is not None:
            expect(
                self.impulse_response,
                ImpulseResponse,
                "impulse_response",
                "omma.photoreceptors.ImpulseResponse.howard gives one",
            )
            if isinstance(self.sampling, Shared):
                raise Error("impulse_response: expected None where rays are shared")
            if min(self.impulse_response.values, default=0.0) < 0:
                raise Error(
                    "impulse_response: expected one that is nowhere negative, as rays draw their "
                    "times from it; omma.photoreceptors.filter_frames takes any"
                )

    def options(self) -> Options:
        """All but the sampling, as keyword arguments of `Renderer`."""
        found: Any = {one.name: getattr(self, one.name) for one in options_of(Settings)}
        if self.impulse_response is not None:
            found["impulse_response"] = self.impulse_response
        return cast(Options, found)

    def _repr_html_(self) -> str:
        rows = {name: str(value) for name, value in settings_as_record(self).items()}
        return html_table("omma.rendering.Settings", rows)

    @property
    def is_noise_frozen(self) -> bool:
        """Whether all frames have the same noise; that of shared rays always is frozen."""
        return self.noise == "frozen" or isinstance(self.sampling, Shared)

    def engine_settings(self, threads: int, eye_sizes: Sequence[int] = ()) -> RenderSettings:
        """As the engine takes them; ``eye_sizes`` are those of a population."""
        sampling = self.sampling
        chosen: tuple[str, int] | tuple[str, float, int, int, float]
        if isinstance(sampling, ToError):
            errors = sampling.error or 0.0, sampling.relative_error or 0.0
            chosen = ("to_error", errors[0], *sampling.limits(), errors[1])
        else:
            chosen = ("shared" if isinstance(sampling, Shared) else "fixed", sampling.samples)
        threads = whole(threads, "threads", 0, 1 << 16)
        options: dict[str, Any] = dict(self.options())
        if len(eye_sizes) > 0:
            options["eye_sizes"] = list(eye_sizes)
        options["kernel"] = options.pop("angular_sensitivity")  # as C++ calls it
        impulse_response = options.pop("impulse_response", None)
        if impulse_response is not None:
            # So many that delays between two quantiles are nearly linear.
            steps = np.linspace(0, 1, _DELAYS)
            options["delays_s"] = np.minimum(
                impulse_response.quantile(steps), impulse_response.duration_s
            ).tolist()
        return _core.RenderSettings(sampling=chosen, threads=threads, **options)


class Options(TypedDict, total=False):
    """The options of `Settings` but the sampling, as keyword arguments, for type checkers."""

    seed: int
    angular_sensitivity: AngularSensitivityName
    points: PointsName
    footprints: bool
    noise: NoiseName
    impulse_response: ImpulseResponse | None


def _document(kind: type) -> None:
    """Put the help of its options where `help` shows it."""
    lines = [f"    {one.name}: {one.metadata['help']}" for one in options_of(kind)]
    kind.__doc__ = "\n".join([f"{kind.__doc__}\n\nArgs:", *lines])


def takes_options(function: F) -> F:
    """The same function, whose signature says ``**options`` one by one, as `Settings` has them."""
    return _with_options(function, lambda one: one.default)


def changes_options(function: F) -> F:
    """As `takes_options`, of a function in which what is not given stays as it was."""
    return _with_options(function, lambda one: None)


def _with_options(function: F, default: Callable[[dataclasses.Field[Any]], Any]) -> F:
    signature = inspect.signature(function)
    parameters = [one for one in signature.parameters.values() if one.kind is not one.VAR_KEYWORD]
    own = [one for one in dataclasses.fields(Settings) if one.name == "impulse_response"]
    for one in [*options_of(Settings), *own]:
        parameters.append(
            inspect.Parameter(
                one.name, inspect.Parameter.KEYWORD_ONLY, default=default(one), annotation=one.type
            )
        )
    function.__signature__ = signature.replace(parameters=parameters)  # type: ignore[attr-defined]
    function.__annotations__ |= option_types(Settings)
    return function


# Few file formats hold larger whole numbers; seeds go up to 2**64 - 1.
_LARGEST_OF_FORMATS = 2**63 - 1


def settings_as_record(settings: Settings) -> dict[str, str | int | float]:
    """Settings as texts and numbers, which every file format can hold, without what is None."""
    flat: dict[str, Any] = {"sampling": type(settings.sampling).__name__}
    for declared in (settings.sampling, settings):
        flat |= {one.name: getattr(declared, one.name) for one in options_of(type(declared))}
    if settings.seed > _LARGEST_OF_FORMATS:
        flat["seed"] = str(settings.seed)
    if settings.impulse_response is not None:
        flat["impulse_response"] = repr(settings.impulse_response)
    return {
        name: int(value) if isinstance(value, bool) else value
        for name, value in flat.items()
        if value is not None
    }


def settings_from_record(record: Mapping[str, Any]) -> Settings:
    """Settings from what `settings_as_record` made of them.

    Raises:
        omma.Error: not such a record.
    """
    if "impulse_response" in record:
        raise Error("settings: those of a renderer with an impulse response are kept as text only")
    kinds = {kind.__name__: kind for kind in get_args(Sampling)}
    kind = kinds[one_of(record.get("sampling"), kinds, "sampling")]
    try:
        values = {**record, "seed": int(record["seed"]), "footprints": bool(record["footprints"])}
        if "kernel" in record:  # files of older versions
            values.setdefault("angular_sensitivity", record["kernel"])
    except (KeyError, ValueError) as error:
        raise Error(f"settings: expected those of a render, found none or wrong: {error}") from None
    of_sampling, others = (
        {one.name: values[one.name] for one in options_of(declared) if one.name in values}
        for declared in (kind, Settings)
    )
    return Settings(kind(**of_sampling), **others)


def frame_number(first_pose: int | None) -> int | None:
    """``first_pose`` of a render, checked."""
    return None if first_pose is None else whole(first_pose, "first_pose", 0, (1 << 63) - 1)


def fixed_samples(sampling: Sampling, what: str) -> int:
    """The number of rays of `Fixed`; omma.Error says that ``what`` needs one."""
    if not isinstance(sampling, Fixed):
        raise Error(f"sampling: expected omma.Fixed for {what}, found {sampling!r:.60}")
    return sampling.samples


for _kind in (Fixed, ToError, Shared, Settings):
    _document(_kind)

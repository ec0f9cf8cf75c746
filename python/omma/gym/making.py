"""Gymnasium environments of loops, where Gymnasium is installed."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from omma.base.arguments import checked, whole
from omma.base.optional import needs
from omma.gym.loop import Loop

if TYPE_CHECKING:
    from types import ModuleType

    import gymnasium
    import gymnasium.vector

_MOST_ENVIRONMENTS = 1 << 20


@checked
def eye_env(loop: Loop) -> gymnasium.Env[Any, Any]:
    """A loop as a Gymnasium environment.

    Observations are what the eye sees, float32 (N, B), or (N, B, frames), in a Box between the
    bounds of the loop; ``info`` has the pose. There is no camera: ``render_mode`` is None,
    ``render()`` gives None and a warning. So does ``step()`` after the end of an episode, which
    goes on.

    Example:
        >>> import gymnasium
        >>> ahead = omma.look_at((0, 0, 0), (0, 0, -1))
        >>> loop = omma.gym.Loop(
        ...     omma.Renderer(omma.scene.box(center_m=(0, 0, -3)), omma.eye.generate_eye(50)),
        ...     start=lambda rng: (0, ahead),
        ...     motion=lambda state, action, rng: (state + action, ahead),
        ...     reward=lambda moment: 0.0,
        ...     action_space=gymnasium.spaces.Discrete(2),
        ... )
        >>> observation, info = omma.gym.eye_env(loop).reset(seed=1)
        >>> observation.shape
        (50, 3)

    Raises:
        omma.Error: no Gymnasium (``omma[gym]``), or a space that is none.
    """
    environment: gymnasium.Env[Any, Any] = _environments().EyeEnv(loop)
    return environment


@checked
def eye_vector_env(loop: Loop, count: int) -> gymnasium.vector.VectorEnv[Any, Any, Any]:
    """So many environments of a loop as one, whose frames are rendered in one call.

    Observations, rewards, ends and infos are, to the bit, those of so many `eye_env` of the same
    seeds in a `gymnasium.vector.SyncVectorEnv`; an environment whose episode is over starts anew at
    the next step (`AutoresetMode.NEXT_STEP`). Of a batched loop one generator is that of all; it
    takes one seed.

    Args:
        count: of environments.

    Raises:
        omma.Error: no Gymnasium (``omma[gym]``), a space that is none, or a count below 1; in
            ``reset`` and ``step``, a function of the loop that moves or changes the world, which
            several environments share.
    """
    number = whole(count, "count", 1, _MOST_ENVIRONMENTS)
    made: gymnasium.vector.VectorEnv[Any, Any, Any] = _environments().EyeVectorEnv(loop, number)
    return made


def _environments() -> ModuleType:
    needs("gymnasium", "gym", "environments need Gymnasium")
    from omma.gym import environments

    return environments

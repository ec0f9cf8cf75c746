from .bounds import response_bounds
from .loop import Loop, Moment
from .making import eye_env, eye_vector_env

__all__ = ["Loop", "Moment", "eye_env", "eye_vector_env", "response_bounds"]

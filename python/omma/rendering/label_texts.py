"""Labels of responses as JSON: beside an `.npy` file, and in the schema of a `.parquet` file."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from omma._core import Error
from omma.rendering.labels import Labels, pose_variables

FORMAT = "omma responses 1"


def labels_text(labels: Labels, files: Mapping[str, str]) -> str:
    """All of the labels; ``files`` says in which file each variable is, where it is in one."""
    # What follows from the poses in full is made again when it is read.
    first = next(iter(labels.variables.values()))[0][0]
    follows = set(pose_variables(np.eye(4)[None], first)) - {"world_from_head"}
    coordinates = {
        name: {
            "dimensions": dimensions,
            "type": "text" if values.dtype.kind == "U" else values.dtype.name,
            "attributes": attributes,
            "values": _plain(values),
        }
        for name, (dimensions, values, attributes) in labels.coordinates.items()
        if name not in follows
    }
    variables = {
        name: {
            "dimensions": dimensions,
            "type": dtype,
            "attributes": attributes,
            **({"file": files[name]} if name in files else {}),
        }
        for name, (dimensions, dtype, attributes) in labels.variables.items()
        if name in files or not files
    }
    sections: dict[str, Mapping[str, Any]] = {
        "attributes": labels.attributes,
        "sizes": labels.sizes,
        "variables": variables,
        "coordinates": coordinates,
    }
    # A line for each thing: a person finds it, and a million numbers are not a line each.
    texts = [f'"format": {json.dumps(FORMAT)}']
    for section, members in sections.items():
        lines = ",\n".join(f"  {json.dumps(k)}: {json.dumps(v)}" for k, v in members.items())
        texts.append(f'"{section}": {{\n{lines}\n}}')
    return "{" + ",\n".join(texts) + "}\n"


def labels_from_text(text: str | bytes, where: str) -> tuple[Labels, dict[str, str]]:
    """What `labels_text` was made of.

    Raises:
        omma.Error: it is something else; ``where`` names it.
    """
    try:
        found = json.loads(text)
        if found["format"] != FORMAT:
            raise ValueError
        coordinates = {
            name: (tuple(one["dimensions"]), _array(one), dict(one["attributes"]))
            for name, one in found["coordinates"].items()
        }
        dimensions, matrices, _ = coordinates["world_from_head"]
        coordinates |= pose_variables(matrices, dimensions[0])
        variables = {
            name: (tuple(one["dimensions"]), str(one["type"]), dict(one["attributes"]))
            for name, one in found["variables"].items()
        }
        files = {
            name: str(one["file"]) for name, one in found["variables"].items() if "file" in one
        }
        labels = Labels(coordinates, dict(found["attributes"]), variables, dict(found["sizes"]))
        shapes = [labels.shape(name) for name in variables]
        if not shapes or not all(isinstance(size, int) for shape in shapes for size in shape):
            raise ValueError
    except (ValueError, TypeError, KeyError, AttributeError, IndexError, OverflowError,
            RecursionError, np.linalg.LinAlgError):  # fmt: skip
        raise Error(f"{where}: expected the JSON that omma writes of responses") from None
    return labels, files


def beside(name: str) -> str:
    """Where the labels of an `.npy` file are."""
    return f"{os.path.splitext(name)[0]}.json"


def _plain(values: np.ndarray[Any, Any]) -> list[Any]:
    """Numbers as JSON has them: not those that are none."""
    plain = values.astype(object)
    if values.dtype.kind == "f":
        plain[~np.isfinite(values)] = None
    return list(plain.tolist())


def _array(one: Any) -> np.ndarray[Any, Any]:
    if one["type"] == "text":
        return np.array(one["values"], dtype=np.str_)
    if np.dtype(one["type"]).kind not in "biuf":
        raise ValueError
    return np.array(one["values"], dtype=one["type"])

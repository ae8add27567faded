"""The model that tells people from other surfaces in a colour picture."""

from __future__ import annotations

import importlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pointbrush.errors import BadInputError

Floats = NDArray[np.float32]
FILE = Path(__file__).parent / "models" / "selfie_segmentation.tflite"
"""Built with the page from the npm package @mediapipe/selfie_segmentation."""
RUNTIME = "ai_edge_litert.interpreter"
MISSING = (
    "people: expected the package ai-edge-litert, it is not installed; "
    "install it: pip install 'pointbrush[people]'"
)


class PersonModel:
    """A network for one picture at a time; not thread-safe.

    Raises BadInputError if its runtime or its file is not installed.
    """

    def __init__(self) -> None:
        self._network = runtime().Interpreter(str(_file()), num_threads=1)
        self._network.allocate_tensors()
        (taken,), (given,) = self._network.get_input_details(), self._network.get_output_details()
        self._taken, self._given = taken["index"], given["index"]
        _, self.height, self.width, _ = map(int, taken["shape"])

    def probability(self, picture: NDArray[np.uint8]) -> Floats:
        """Return the probability that a picture (h, w, 3) shows a person, by pixel.

        The answer (height, width) covers the picture in the network's own size.
        """
        size = self.width, self.height
        fitting = Image.fromarray(picture).resize(size, Image.Resampling.BILINEAR)
        self._network.set_tensor(self._taken, np.asarray(fitting)[None] * np.float32(1 / 255))
        self._network.invoke()
        return np.asarray(self._network.get_tensor(self._given)[0, :, :, 0])


@cache
def runtime() -> Any:
    """Return the module that runs networks; raises BadInputError if it is not installed."""
    try:
        return importlib.import_module(RUNTIME)
    except ImportError:
        raise BadInputError(MISSING) from None


def _file() -> Path:
    if not FILE.is_file():
        raise BadInputError(f"people: expected the model {FILE.name}; `make page` builds it")
    return FILE

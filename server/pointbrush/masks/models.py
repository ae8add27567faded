"""Users' own models that find masks in pictures: plug-ins, and services over HTTP.

A package adds a model with an entry point of the group ``pointbrush.masks``: a class or function
that returns a ``MaskModel`` when it is called without arguments.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import ClassVar, Protocol

import numpy as np
from numpy.typing import NDArray

from pointbrush.errors import UnavailableError
from pointbrush.exchange.model_names import ModelNames
from pointbrush.exchange.npz import Arrays
from pointbrush.exchange.npz_service import TIMEOUT, NpzService

MOST_MASKS = 10_000
"""Most masks in an answer."""
NAME_LENGTH = 200
"""Most characters of the name of a class."""
ANSWER_BYTES = 256 * 2**20
"""Most bytes of the answer of a service."""


@dataclass(frozen=True, slots=True, eq=False)
class Prompt:
    """A picture (H, W, 3) uint8, with optional clicks (P, 2), column and row, and text."""

    picture: NDArray[np.uint8]
    positives: NDArray[np.float64]
    negatives: NDArray[np.float64]
    text: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class FoundMasks:
    """Masks of a picture as one image (H, W) uint16: 0, or 1 to K for the K ``names``."""

    mask: NDArray[np.uint16]
    names: tuple[str, ...]


class MaskModel(Protocol):
    """A model that finds masks in pictures; several threads call it."""

    def masks(self, prompt: Prompt) -> FoundMasks:
        """Return the masks for a prompt, with the class of each."""


class HttpMaskModel:
    """A ``MaskModel`` on another machine: version 1 of the call, a POST of .npz, .npz back.

    ``{address}/v1/masks``  ``picture`` uint8 (H, W, 3); ``positives``, ``negatives`` float64
                            (·, 2), column and row; ``text``.  Answer: ``mask`` uint16 (H, W), and
                            ``names`` text (K,), the class of the values 1 to K.
    """

    def __init__(self, address: str, name: str) -> None:
        self._service = NpzService(address, f"model {name}", ANSWER_BYTES)

    def masks(self, prompt: Prompt) -> FoundMasks:
        """Send a prompt and return the masks of the answer; see ``MaskModel``."""
        arrays: Arrays = {
            "picture": prompt.picture,
            "positives": prompt.positives,
            "negatives": prompt.negatives,
            "text": np.array(prompt.text),
        }
        answer = self._service.call("masks", arrays, TIMEOUT)
        mask, names = (answer.get(name, np.empty(0)) for name in ("mask", "names"))
        if names.dtype.kind != "U" or names.ndim != 1:
            raise UnavailableError(
                f"{self._service.role}: expected names, text (K,), got {names.dtype} {names.shape}"
            )
        return FoundMasks(mask, tuple(map(str, names)))


class MaskModels(ModelNames):
    """Models of masks that the operator of the server allows, by name."""

    GROUP: ClassVar[str] = "pointbrush.masks"
    OPTION: ClassVar[str] = "mask_models"

    def masks(self, name: str, prompt: Prompt) -> FoundMasks:
        """Return the checked masks of a model.

        Raises BadInputError (unknown model), UnavailableError (no answer, or an invalid one).
        """
        model = _made(name, self.address(name))
        return checked_masks(name, prompt, model.masks(prompt))


@lru_cache(maxsize=64)
def _made(name: str, address: str | None) -> MaskModel:
    """Make a model once a process: the weights of a plug-in may be large."""
    if address is not None:
        return HttpMaskModel(address, name)
    model: MaskModel = MaskModels.plug_in(name)
    return model


def checked_masks(name: str, prompt: Prompt, found: FoundMasks) -> FoundMasks:
    """Return ``found`` if its masks fit the picture; raises UnavailableError."""
    shape, mask = prompt.picture.shape[:2], np.asarray(found.mask)
    if mask.shape != shape or mask.dtype != np.uint16:
        raise UnavailableError(
            f"model {name}: expected mask uint16 {shape}, got {mask.dtype} {mask.shape}"
        )
    if len(found.names) > MOST_MASKS or int(mask.max(initial=0)) > len(found.names):
        raise UnavailableError(
            f"model {name}: expected values up to the number of names, at most {MOST_MASKS}, got "
            f"{int(mask.max(initial=0))} with {len(found.names)} names"
        )
    bad = [each for each in found.names if not 0 < len(each.strip()) <= NAME_LENGTH]
    if bad:
        raise UnavailableError(
            f"model {name}: expected names of 1 to {NAME_LENGTH} characters, got {bad[0][:40]!r}"
        )
    return found

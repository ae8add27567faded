"""Find masks in pictures in your own service: a toy in place of a network like SAM, over HTTP.

    python docs/examples/mask_server.py --port 9200
    pointbrush serve --mask-models toy=http://127.0.0.1:9200

The toy returns the pixels with colours like those of the clicks, or, without clicks, the pixels of
the colour that the text names.  Replace ``masks`` by your network.  docs/howto/own-model.md
describes the call.
"""

from __future__ import annotations

import numpy as np
from selector_server import serve  # the file beside this one: calls as .npz over HTTP

Arrays = dict[str, np.ndarray]
COLORS = {"red": (255, 0, 0), "green": (0, 255, 0), "blue": (0, 0, 255)}
ALIKE = 60
"""Greatest difference of two colours, summed over red, green and blue, of one object."""


def masks(given: Arrays) -> Arrays:
    """Return an image of values, and the name of the class of each value from 1."""
    picture, text = given["picture"].astype(int), str(given["text"])

    def difference(color: np.ndarray) -> np.ndarray:
        return np.abs(picture - color).sum(axis=2)

    def nearest(clicks: np.ndarray) -> np.ndarray:
        places = [(int(row), int(column)) for column, row in clicks]
        return np.min([difference(picture[place]) for place in places], axis=0)

    if len(given["positives"]):
        found = nearest(given["positives"]) <= ALIKE
        if len(given["negatives"]):
            found &= nearest(given["negatives"]) > ALIKE
        names = [text or "object"]
    else:
        names = [name for name in COLORS if name in text]
        found = np.zeros(picture.shape[:2], int)
        for value, name in enumerate(names, 1):
            found[difference(np.array(COLORS[name])) <= ALIKE] = value
    return {"mask": found.astype(np.uint16), "names": np.array(names, "U")}


if __name__ == "__main__":
    serve({"/v1/masks": masks}, "mask model", 9200)

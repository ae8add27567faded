"""One frame of an imported recording, as it is stored."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import fields
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pointbrush.cache import Cache
from pointbrush.errors import BadInputError, NotFoundError, TooLargeError
from pointbrush.frame import DepthCamera, Sensor
from pointbrush.sequences import kdtree
from pointbrush.sequences.blocks import Blocks
from pointbrush.sequences.depth.lattice import Lattice
from pointbrush.sequences.octree.coordinates import Coordinates
from pointbrush.sequences.storage.frame_files import CopiedFiles, MappedFiles
from pointbrush.sequences.storage.manifest import Manifest
from pointbrush.sequences.stored_part import StoredPart
from pointbrush.values.frames import Chunk

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

_TREE_POINTS = 6_000_000
_trees: Cache[tuple[str, str, int], cKDTree[None]] = Cache(_TREE_POINTS)
"""Trees of all sequences together, bounded by their points (about 45 bytes each)."""


_CHUNK_COLUMNS = [field.name for field in fields(Chunk)][1:-1]


class StoredFrame:
    """One frame; arrays are read-only, in stored order, shared by all threads.

    Every method that reads its files raises DamagedError, naming the frame, if they are damaged.

    ``pose``          (4, 4) ``T_world_frame`` in the source's coordinates, or None.
    ``viewpoint``     (3,) the sensor's position, local metres, or None; the first of several.
    ``timestamp``     seconds, or None.
    ``sensors``       the sensors of a recording of several, else ().
    """

    def __init__(self, files: CopiedFiles | MappedFiles, manifest: Manifest) -> None:
        index = files.index
        self.index, self.count, self.large = index, files.count, files.large
        self._files, self._placement = files, manifest.placement
        self._stored_sensors = manifest.sensors
        self.sensors = tuple(Sensor(each.name, each.type) for each in manifest.sensors)
        self._shift, self._lattice = np.array(manifest.shift), manifest.lattice
        self._sends_depth = manifest.sends_depth
        pose, viewpoint = manifest.poses[index], manifest.viewpoints[index]
        self.pose = None if pose is None else np.array(pose).reshape(4, 4)
        self.viewpoint = None if viewpoint is None else np.array(viewpoint) - self._shift
        self.timestamp = manifest.timestamps[index]
        if self.sensors and self.parts:
            self.viewpoint = self.parts[0].viewpoint

    def __len__(self) -> int:
        return self.count

    @property
    def xyz(self) -> NDArray[np.float32]:
        """(N, 3) float32, local metres; for an octree, ``coordinates`` takes less memory."""
        return self._files.array("xyz")

    @property
    def coordinates(self) -> NDArray[np.float32] | Coordinates:
        """Local coordinates by point number; an octree unpacks only the requested points."""
        return self._files.coordinates()

    @property
    def source_index(self) -> NDArray[np.uint32]:
        """(N,) uint32: ``source_array[source_index]`` is in stored order."""
        return self._files.array("source_index")

    def _column(self, name: str) -> NDArray[Any] | None:
        return self._files.array(name) if name in self._files.names else None

    @property
    def rgb(self) -> NDArray[np.uint8] | None:
        """(N, 3) colours, or None."""
        return self._column("rgb")

    @property
    def intensity(self) -> NDArray[np.float32] | None:
        """(N,) in the source's unit, or None."""
        return self._column("intensity")

    @property
    def label(self) -> NDArray[np.uint16] | None:
        """(N,) annotation of the source, or None."""
        return self._column("label")

    @property
    def instance(self) -> NDArray[np.uint16] | None:
        """(N,) instance numbers of the source, or None."""
        return self._column("instance")

    @property
    def pixel(self) -> NDArray[np.uint32] | None:
        """(N,) row-major pixels of ``camera``'s image, or None."""
        return self._column("pixel")

    @property
    def camera(self) -> DepthCamera | None:
        """Intrinsics when the frame came from a depth image."""
        camera = self._files.meta.get("camera")
        return None if camera is None else DepthCamera(**camera)

    @property
    def lattice(self) -> Lattice | None:
        """The pixels that the frame's points lie on, as the import found them, or None.

        None for several sensors: ``parts`` have a lattice each.
        """
        return None if self._files.depth_ends is None else self._lattice

    @property
    def sensor(self) -> NDArray[np.uint8] | None:
        """(N,) number of each point's sensor in ``sensors``, or None: there is one sensor."""
        return self._column("sensor")

    @cached_property
    def parts(self) -> tuple[StoredPart, ...]:
        """The sensors that recorded this frame, with their corrected mounts."""
        if not self.sensors:
            return (StoredPart.alone(self.viewpoint, self.timestamp, self.lattice, self.camera),)
        chunks = self.chunk_table
        cameras = self._files.meta["cameras"]
        return tuple(
            StoredPart.of(
                number,
                stored,
                self.index,
                self._shift,
                on_lattice=bool(chunks["depth"][chunks["sensor"] == number].any()),
                camera=cameras.get(str(number)),
            )
            for number, stored in enumerate(self._stored_sensors)
            if (chunks["sensor"] == number).any()
        )

    def sensor_xyz(self) -> NDArray[np.float32] | NDArray[np.float64]:
        """Points (N, 3) in their sensors' coordinates: source order, bit for bit as imported.

        Those of one sensor are its ``source_xyz``.
        """
        if not self.sensors:
            return self.source_xyz()
        return self.to_source(self._files.array("sensor_xyz"))

    def to_source(self, stored_values: NDArray[Any]) -> NDArray[Any]:
        """A per-point array (N, …) from stored into source order."""
        values = np.asarray(stored_values)
        if len(values) != self.count:
            raise BadInputError(f"expected {self.count} values, got {len(values)}")
        out = np.empty_like(values)
        out[self.source_index] = values
        return out

    def source_xyz(self) -> NDArray[np.float32] | NDArray[np.float64]:
        """Coordinates (N, 3) as they were imported: source order, shift undone, bit for bit.

        A correction of a mount moves the points of its sensor.
        """
        return self.to_source(self._files.source(0, self.count))

    def read(self, name: str, first: int, stop: int) -> NDArray[Any]:
        """Rows ``first`` to before ``stop`` of a stored array.

        Rows of an octree are read instead of mapped, so that reading all rows in turn does not
        fill this process's memory.
        """
        return self._files.rows(name, first, stop)

    def release(self) -> None:
        """Release the pages of mapped memory that were read; the next access reads them again.

        Raises DamagedError if a file has been truncated.
        """
        self._files.release()

    def look(self) -> None:
        """Raise DamagedError if a mapped file of the frame has been truncated."""
        self._files.look()

    def verify(self, names: Collection[str]) -> int:
        """Compare the files of columns ``names`` with their checksums, unless this process has.

        They include ``source_index`` and the arrays of ``xyz``.  Raises DamagedError: call this
        before the first byte of a long answer.  Returns the files' bytes.
        """
        return self._files.verify(
            {*names, "source_index", *(("residual",) if "xyz" in names else ())}
        )

    def read_source(self, first: int, stop: int, names: Collection[str]) -> dict[str, NDArray[Any]]:
        """Return the columns ``names`` that the frame has, stored order, as imported.

        ``xyz`` are source coordinates, bit for bit.
        """
        columns = {
            name: self.read(name, first, stop)
            for name in names
            if name != "xyz" and name in self._files.names
        }
        if "xyz" in names:
            columns["xyz"] = self._files.source(first, stop)
        return columns

    @cached_property
    def blocks(self) -> Blocks:
        """Bounding boxes of runs of at most 256 points."""
        array, chunks = self._files.array, self.chunk_table
        return Blocks(
            first=array("block_first"),
            lo=array("block_lo"),
            hi=array("block_hi"),
            chunk_first=array("block_of_chunk"),
            chunk_lo=np.ascontiguousarray(chunks["lo"]),
            chunk_hi=np.ascontiguousarray(chunks["hi"]),
        )

    @property
    def chunk_table(self) -> NDArray[Any]:
        """The chunks as one structured array (``chunk.CHUNK``)."""
        return self._files.chunks

    @cached_property
    def chunks(self) -> list[Chunk]:
        """All chunks, in the order of their points and bytes."""
        names = [*_CHUNK_COLUMNS, *(("sensor",) if self.sensors else ())]
        columns: list[list[Any]] = [
            list(map(tuple, values)) if values and isinstance(values[0], list) else values
            for values in (self.chunk_table[name].tolist() for name in names)
        ]
        return list(map(Chunk, range(len(self.chunk_table)), *columns))

    def wire(self, first_chunk: int, stop_chunk: int) -> memoryview:
        """The encoded bytes of chunks ``first_chunk`` to before ``stop_chunk``.

        Offsets of chunks count from the start of the frame's wire file.  Raises DamagedError.
        """
        table = self.chunk_table
        if not 0 <= first_chunk <= stop_chunk <= len(table):
            raise NotFoundError(
                f"expected chunks within 0..{len(table)}, got {first_chunk}..{stop_chunk}"
            )
        if first_chunk == stop_chunk:
            return memoryview(b"")
        start = int(table["offset"][first_chunk])
        stop = int(table["offset"][stop_chunk - 1] + table["nbytes"][stop_chunk - 1])
        return self._files.wire(start, stop)

    @property
    def depth_ends(self) -> NDArray[np.int64] | None:
        """Ends of the chunks (C,) in the wire file as parts of a depth image, None without one.

        One in an older format counts as none.
        The chunks are the same points; the first one begins where the encoded points end.
        """
        return self._files.depth_ends if self._sends_depth else None

    def is_band(self, chunk: int) -> bool:
        """Return whether a chunk of a frame with ``depth_ends`` is a part of a depth image there.

        Chunks of those of several sensors that have none are points there, too.
        """
        return not self.sensors or bool(self.chunk_table["depth"][chunk])

    def depth(self, first_chunk: int, stop_chunk: int) -> memoryview:
        """The bytes of the same chunks as parts of the frame's depth image; raises DamagedError."""
        ends = self.depth_ends
        if ends is None or not 0 <= first_chunk <= stop_chunk <= len(ends):
            raise NotFoundError(
                f"expected chunks within 0..{0 if ends is None else len(ends)} of a depth image, "
                f"got {first_chunk}..{stop_chunk}"
            )
        start, stop = (self.depth_start(chunk) for chunk in (first_chunk, stop_chunk))
        return self._files.wire(start, stop)

    def depth_start(self, chunk: int) -> int:
        """Offset of a chunk in the wire file as a part of the frame's depth image."""
        if chunk and self.depth_ends is not None:
            return int(self.depth_ends[chunk - 1])
        return int(self.chunk_table["offset"][-1] + self.chunk_table["nbytes"][-1])

    @property
    def kdtree(self) -> cKDTree[None]:
        """The tree over ``xyz``, built once and shared; querying it is thread-safe.

        Raises TooLargeError for an octree's frame: build one over the points of a region.
        """
        if isinstance(self._files, MappedFiles):
            raise TooLargeError(
                f"frame {self.index}: expected a frame small enough for a k-d tree, "
                f"got {self.count:,} points"
            )
        return _trees.get(
            (str(self._files.path), self._placement, self.index),
            lambda: kdtree.build(self.xyz),
            size=max(self.count, 1),
        )

"""An imported recording on disk: order, chunks, spatial index, k-d tree; immutable afterwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.sequences.blocks import Blocks
    from pointbrush.sequences.check import note_checksums, verify
    from pointbrush.sequences.depth.lattice import Lattice
    from pointbrush.sequences.files import clean_temporary
    from pointbrush.sequences.importer import LARGE_POINTS, import_frames, import_large
    from pointbrush.sequences.manifest import Manifest, read_manifest, update_manifest
    from pointbrush.sequences.octree.coordinates import load_loops
    from pointbrush.sequences.source_order import source_blocks
    from pointbrush.sequences.store import Sequence, open_sequence
    from pointbrush.sequences.stored_frame import Chunk, StoredFrame

__all__ = [
    "LARGE_POINTS",
    "Blocks",
    "Chunk",
    "Lattice",
    "Manifest",
    "Sequence",
    "StoredFrame",
    "clean_temporary",
    "import_frames",
    "import_large",
    "load_loops",
    "note_checksums",
    "open_sequence",
    "read_manifest",
    "source_blocks",
    "update_manifest",
    "verify",
]
_PLACES = {
    "Blocks": "pointbrush.sequences.blocks",
    "note_checksums": "pointbrush.sequences.check",
    "verify": "pointbrush.sequences.check",
    "Lattice": "pointbrush.sequences.depth.lattice",
    "clean_temporary": "pointbrush.sequences.files",
    "LARGE_POINTS": "pointbrush.sequences.importer",
    "import_frames": "pointbrush.sequences.importer",
    "import_large": "pointbrush.sequences.importer",
    "Manifest": "pointbrush.sequences.manifest",
    "read_manifest": "pointbrush.sequences.manifest",
    "update_manifest": "pointbrush.sequences.manifest",
    "load_loops": "pointbrush.sequences.octree.coordinates",
    "source_blocks": "pointbrush.sequences.source_order",
    "Sequence": "pointbrush.sequences.store",
    "open_sequence": "pointbrush.sequences.store",
    "Chunk": "pointbrush.sequences.stored_frame",
    "StoredFrame": "pointbrush.sequences.stored_frame",
}
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__, _PLACES)

"""An imported recording on disk: order, chunks, spatial index, k-d tree; immutable afterwards."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pointbrush.lazy import lazily

if TYPE_CHECKING:
    from pointbrush.sequences.check import note_checksums, verify
    from pointbrush.sequences.depth.lattice import Lattice
    from pointbrush.sequences.importer import LARGE_POINTS, import_frames, import_large
    from pointbrush.sequences.octree.coordinates import load_loops
    from pointbrush.sequences.record import RecordingInfo
    from pointbrush.sequences.source_order import source_blocks
    from pointbrush.sequences.storage.files import clean_temporary
    from pointbrush.sequences.storage.manifest import Manifest, read_manifest, update_manifest
    from pointbrush.sequences.store import Sequence, open_sequence
    from pointbrush.sequences.stored_frame import StoredFrame
if not TYPE_CHECKING:
    __getattr__ = lazily(__name__)

"""An imported recording on disk: order, chunks, spatial index, k-d tree; immutable afterwards."""

from pointbrush.sequences.blocks import Blocks
from pointbrush.sequences.check import note_checksums, verify
from pointbrush.sequences.files import clean_temporary
from pointbrush.sequences.importer import LARGE_POINTS, import_frames, import_large
from pointbrush.sequences.manifest import Manifest, read_manifest, update_manifest
from pointbrush.sequences.source_order import source_blocks
from pointbrush.sequences.store import Sequence, open_sequence
from pointbrush.sequences.stored_frame import Chunk, StoredFrame

__all__ = [
    "LARGE_POINTS",
    "Blocks",
    "Chunk",
    "Manifest",
    "Sequence",
    "StoredFrame",
    "clean_temporary",
    "import_frames",
    "import_large",
    "note_checksums",
    "open_sequence",
    "read_manifest",
    "source_blocks",
    "update_manifest",
    "verify",
]

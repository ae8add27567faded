"""Run as a script: decompress LAZ points to standard output, within a memory limit.

Arguments: path, offset of the points, bytes of a record, number of points, the laszip record in
base64, bytes of memory.  Imports nothing of pointbrush, so that it starts in milliseconds.
"""

from __future__ import annotations

import base64
import sys

BLOCK = 50_000


def main(arguments: list[str]) -> int:
    """Write all records; return 1 and write a line to stderr if they cannot be decoded."""
    path, offset, record, count, laszip, memory = arguments
    _limit_memory(int(memory))
    import lazrs

    try:
        description = base64.b64decode(laszip)
        if lazrs.LazVlr(description).item_size() != int(record):
            print("records of another length than the header says", file=sys.stderr)
            return 1
        with open(path, "rb") as source:  # noqa: PTH123
            source.seek(int(offset))
            decoder = lazrs.LasZipDecompressor(source, description)
            left = int(count)
            while left > 0:
                block = bytearray(min(left, BLOCK) * int(record))
                decoder.decompress_many(block)
                sys.stdout.buffer.write(block)
                left -= min(left, BLOCK)
            sys.stdout.buffer.flush()
    # A panic of the native decoder raises its own subclass of BaseException.
    except BaseException as error:
        print(str(error) or type(error).__name__, file=sys.stderr)
        return 1
    return 0


def _limit_memory(size: int) -> None:
    try:
        import resource
    except ImportError:  # not on Windows
        return
    resource.setrlimit(resource.RLIMIT_AS, (size, size))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

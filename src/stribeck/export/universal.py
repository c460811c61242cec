"""One macOS binary for both of its processors, as FMI 2 wants it: it knows a single folder for that system."""

from __future__ import annotations

import struct
from collections.abc import Sequence

_MAGIC, _THIN = 0xCAFEBABE, 0xFEEDFACF
_ALIGN = 14  # both processors' pages fit 2^14 bytes


def universal(binaries: Sequence[bytes]) -> bytes:
    """Return the universal ("fat") Mach-O file of 64-bit Mach-O files; a single one is returned as it is.

    Notes
    -----
    Layout as in Apple's ``mach-o/fat.h``: a header in big-endian words, an entry a processor (type, subtype, offset,
    size, alignment), then the files, each at a multiple of the alignment.
    """
    if len(binaries) == 1:
        return binaries[0]
    page = 1 << _ALIGN
    out = bytearray(struct.pack(">II", _MAGIC, len(binaries)).ljust(page, b"\0"))
    for i, data in enumerate(binaries):
        magic, kind, sub = struct.unpack_from("<III", data)
        if magic != _THIN:
            raise ValueError("not a 64-bit Mach-O file")
        struct.pack_into(">IIIII", out, 8 + 20 * i, kind, sub, len(out), len(data), _ALIGN)
        out += data
        out += bytes(-len(out) % page)
    return bytes(out)

"""Which libraries an ELF file asks the dynamic linker for.

Format: System V ABI, chapters 4 and 5; 64 bit, little endian, as all FMUs here.
"""

import struct

SECTION_DYNAMIC = 6
DT_NEEDED = 1


def needed_libraries(data: bytes) -> list[str]:
    """Return the NEEDED entries of a 64-bit little-endian ELF file, else none."""
    if data[:6] != b"\x7fELF\x02\x01":
        return []
    try:
        return _needed(data)
    except (struct.error, ValueError, UnicodeDecodeError):
        return []


def _needed(data: bytes) -> list[str]:
    (start,) = struct.unpack_from("<Q", data, 40)
    size, count = struct.unpack_from("<HH", data, 58)
    sections = [
        # type at 4, offset at 24, size at 32, link at 40
        (
            *struct.unpack_from("<I", data, start + i * size + 4),
            *struct.unpack_from("<QQI", data, start + i * size + 24),
        )
        for i in range(count)
    ]
    found = []
    for kind, offset, length, link in sections:
        if kind != SECTION_DYNAMIC:
            continue
        strings = sections[link][1]
        for tag, value in struct.iter_unpack("<QQ", data[offset : offset + length]):
            if tag == DT_NEEDED:
                begin = strings + value
                found.append(data[begin : data.index(b"\0", begin)].decode())
    return found

"""Images of 16 bits as PNG, written and read with numpy and zlib alone.

All readers of PNG open them. Rows are stored as differences to the row before ("Up"). Their bytes have Huffman codes of
their own (P. Deutsch, RFC 1951, 1996) without a search for repetitions, which noise does not have: a tenth of the time
of zlib for files as small.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from hcss_twin.core.kernels import kernel

_SIGNATURE = b"\x89PNG\r\n\x1a\n"
_UP, _DEPTH, _GREY = 2, 16, 0


def encoded(image: NDArray[np.uint16] | NDArray[np.uint8]) -> bytes:
    """Return the PNG file of an image (y, x)."""
    rows, columns = image.shape
    samples = np.ascontiguousarray(image.astype(image.dtype.newbyteorder(">"))).view(np.uint8).reshape(rows, -1)
    lines = np.empty((rows, samples.shape[1] + 1), dtype=np.uint8)
    lines[:, 0], lines[0, 1:] = _UP, samples[0]
    np.subtract(samples[1:], samples[:-1], out=lines[1:, 1:])
    data = _deflated(lines.ravel())
    header = struct.pack(">IIBBBBB", columns, rows, 8 * image.itemsize, _GREY, 0, 0, 0)
    parts = ((b"IHDR", header), (b"IDAT", data), (b"IEND", b""))
    return _SIGNATURE + b"".join(_chunk(kind, content) for kind, content in parts)


_END, _LONGEST = 256, 15
"""Symbol after the last byte, and bits of the longest code."""

_ORDER = (16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15)
"""Lengths of codes in the order in which a block gives the lengths of their own codes."""


_FOUR_BITS = [int(f"{number:04b}"[::-1], 2) for number in range(16)]
"""Codes of the lengths 0 to 15."""


def _deflated(content: NDArray[np.uint8]) -> bytes:
    """Return bytes as a stream of zlib with one block, whose codes are for bytes alone."""
    counts = np.append(np.bincount(content, minlength=_END), 1)
    lengths = _code_lengths(counts)
    # One distance code of one bit, which nothing uses; lengths are given by codes of four bits each, without repeats.
    start = [(1, 1), (2, 2), (0, 5), (0, 5), (len(_ORDER) - 4, 4)]
    start += [(0 if length > _LONGEST else 4, 3) for length in _ORDER]
    start += [(_FOUR_BITS[length], 4) for length in (*lengths.tolist(), 1)]
    value = bits = 0
    for number, size in start:
        value, bits = value | number << bits, bits + size
    size = (bits + int(counts @ lengths) + 7) // 8
    packed = np.zeros(size // 4 + 2, np.uint32)
    head = np.frombuffer(value.to_bytes(bits // 32 * 4 + 4, "little"), "<u4")
    packed[: head.size] = head
    _pack(content, _codes(lengths).astype(np.uint64) | lengths.astype(np.uint64) << np.uint64(32), packed, bits)
    return b"\x78\x01" + packed.astype("<u4").tobytes()[:size] + struct.pack(">I", zlib.adler32(content.tobytes()))


def _code_lengths(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the length of the Huffman code of each symbol, 0 for those that do not occur (D. A. Huffman, 1952).

    Where one would be too long, rare symbols are counted as more frequent than they are.
    """
    lengths = np.zeros(counts.size, np.int64)
    present = np.flatnonzero(counts)
    order = present[np.argsort(counts[present], kind="stable")]
    lengths[order] = _depths(counts[order])
    if lengths.max() > _LONGEST:
        return _code_lengths(np.where(counts, counts // 2 + 1, 0))
    return lengths


@kernel()
def _depths(counts):  # type: ignore[no-untyped-def]
    """Return the depths in Huffman's tree of leaves with ascending counts (N,), N above 1."""
    leaves = counts.size
    nodes = 2 * leaves - 1
    weights, parents = np.empty(nodes, np.int64), np.zeros(nodes, np.int64)
    weights[:leaves] = counts
    leaf, inner = 0, leaves
    for node in range(leaves, nodes):
        total = 0
        for _ in range(2):
            if leaf < leaves and (inner == node or weights[leaf] <= weights[inner]):
                lightest, leaf = leaf, leaf + 1
            else:
                lightest, inner = inner, inner + 1
            parents[lightest] = node
            total += weights[lightest]
        weights[node] = total
    depths = np.zeros(nodes, np.int64)
    for node in range(nodes - 2, -1, -1):
        depths[node] = depths[parents[node]] + 1
    return depths[:leaves]


def _codes(lengths: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return the code of each symbol with its first bit lowest: by length, then in order (RFC 1951, section 3.2.2)."""
    of_length = np.bincount(lengths, minlength=_LONGEST + 1)
    of_length[0] = code = 0
    codes = np.zeros(lengths.size, np.int64)
    for length in range(1, _LONGEST + 1):
        code = (code + int(of_length[length - 1])) << 1
        codes[lengths == length] = code + np.arange(of_length[length])
    turned = np.zeros_like(codes)
    for bit in range(_LONGEST):
        turned |= np.where(bit < lengths, (codes >> bit & 1) << np.maximum(lengths - 1 - bit, 0), 0)
    return turned


@kernel()
def _pack(content, codes, packed, bits):  # type: ignore[no-untyped-def]
    """Write codes of bytes and of the end into words of 32 bits, from a bit on: bits, and their number above 32."""
    at, used = bits // 32, np.uint64(bits % 32)
    held, half = np.uint64(packed[at]), np.uint64(32)
    for n in range(content.size):
        code = codes[content[n]]
        held |= (code & np.uint64(0xFFFF)) << used
        used += code >> half
        if used >= half:
            packed[at] = np.uint32(held & np.uint64(0xFFFFFFFF))
            at, held, used = at + 1, held >> half, used - half
    held |= (codes[codes.size - 1] & np.uint64(0xFFFF)) << used
    packed[at], packed[at + 1] = np.uint32(held & np.uint64(0xFFFFFFFF)), np.uint32(held >> half)


def decoded(file: bytes) -> NDArray[np.uint16]:
    """Return the image (y, x) of a PNG file that :func:`encoded` made.

    Raises
    ------
    ValueError
        If it is no such file.
    """
    if not file.startswith(_SIGNATURE):
        raise ValueError("no PNG file")
    chunks = dict[bytes, bytes]()
    for kind, content in _chunks(file):
        chunks[kind] = chunks.get(kind, b"") + content
    columns, rows, depth, colour, *_ = struct.unpack(">IIBBBBB", chunks[b"IHDR"])
    lines = np.frombuffer(zlib.decompress(chunks[b"IDAT"]), dtype=np.uint8)
    if (depth, colour) != (_DEPTH, _GREY) or lines.size != rows * (2 * columns + 1):
        raise ValueError("not a grey PNG of 16 bits")
    lines = lines.reshape(rows, 2 * columns + 1)
    if np.any(lines[:, 0] != _UP):
        raise ValueError("rows of a PNG that are not differences to the row before; allowed: files of a data set")
    samples = np.cumsum(lines[:, 1:], axis=0, dtype=np.uint8)
    return samples.view(">u2").astype(np.uint16)


def _chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def _chunks(file: bytes) -> Iterator[tuple[bytes, bytes]]:
    at = len(_SIGNATURE)
    while at < len(file):
        size, kind = struct.unpack(">I4s", file[at : at + 8])
        content = file[at + 8 : at + 8 + size]
        if len(content) < size or zlib.crc32(kind + content) != struct.unpack(">I", file[at + 8 + size :][:4])[0]:
            raise ValueError("a damaged PNG file")
        yield kind, content
        at += 12 + size

"""Writes one message of each type, as the official Python package encodes it.

    golden.py GENERATED GOLDEN [--compare]

The n-th single value of a message in wire order, counted from 1, is n (modulo 100 for integers),
n + 0.5 for floats, true for odd n, and "sn" for strings; lengths of arrays are 2. The last field
`crc` is the CRC-32 of the bytes before it. With --compare nothing is written: what is there must
be what would be.
"""

import pathlib
import struct
import sys
import zlib

from generated import classes

kinds = classes(sys.argv[1])
by_class = {kind.__name__: kind for kind in kinds.values()}


def fill(kind, count):
    message = kind()
    lengths = {size for dims in kind.__dimensions__ for size in dims or () if isinstance(size, str)}

    def single(name, typename):
        count[0] += 1
        n = count[0]
        if name in lengths:
            return 2
        if typename in ("float", "double"):
            return n + 0.5
        if typename == "boolean":
            return n % 2 == 1
        if typename == "string":
            return f"s{n}"
        return n % 100

    def value(name, typename, dims):
        if dims:
            size = 2 if isinstance(dims[0], str) else dims[0]
            rows = [value(name, typename, dims[1:]) for _ in range(size)]
            return bytes(rows) if typename == "byte" and len(dims) == 1 else rows
        if "." in typename or typename in by_class:
            return fill(by_class[typename.rsplit(".", 1)[-1]], count)
        return single(name, typename)

    for name, typename, dims in zip(kind.__slots__, kind.__typenames__, kind.__dimensions__):
        setattr(message, name, value(name, typename, dims or []))
    return message


for name, kind in kinds.items():
    if not name.startswith("lmpc."):
        continue
    message = fill(kind, [0])
    if kind.__slots__[-1] == "crc":
        message.crc = struct.unpack(">i", struct.pack(">I", zlib.crc32(message.encode()[:-4])))[0]
    path = pathlib.Path(sys.argv[2]) / f"{name}.bin"
    if "--compare" not in sys.argv:
        path.write_bytes(message.encode())
    elif path.read_bytes() != message.encode():
        raise SystemExit(f"{path} differs from what Python encodes")
print("golden messages:", "compared" if "--compare" in sys.argv else "written")

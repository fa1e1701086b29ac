"""Prints the fingerprint of every class lcm-gen made in the folder given."""

import struct
import sys

from generated import classes

for name, kind in sorted(classes(sys.argv[1]).items()):
    fingerprint = struct.unpack(">Q", kind._get_packed_fingerprint())[0]
    print(f"{name} {fingerprint:016x}")

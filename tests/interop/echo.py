"""Decodes each message on standard input with lcm-gen's classes and encodes it again."""

import struct
import sys

from generated import classes

kinds = classes(sys.argv[1])
read, write = sys.stdin.buffer.read, sys.stdout.buffer.write
while length := read(4):
    name = read(struct.unpack(">I", length)[0])
    data = read(struct.unpack(">I", read(4))[0])
    again = kinds[name.decode()].decode(data).encode()
    for part in (name, again):
        write(struct.pack(">I", len(part)) + part)

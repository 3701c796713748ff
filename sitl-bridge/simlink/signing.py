"""The key of MAVLink 2 signatures, from a file that only its owner reads."""

import os
import stat

KEY_BYTES = 32


class KeyFileError(Exception):
    """A key that cannot be used; the message says why, and never what stands in the file."""


def read_key(path: str) -> bytes:
    """The key in `path`: 64 hexadecimal digits, white space around them allowed, or 32 raw bytes."""
    try:
        with open(path, "rb") as file:
            permissions = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
            content = file.read(1024)
    except OSError as error:
        raise KeyFileError(f"cannot read the signing key {path}: {error.strerror}") from None
    if permissions & 0o077:
        raise KeyFileError(f"others may read the signing key {path}; run: chmod 600 {path}")
    if len(content) == KEY_BYTES:
        return content
    try:
        key = bytes.fromhex(content.decode("ascii"))
    except ValueError:
        key = b""
    if len(key) != KEY_BYTES:
        raise KeyFileError(f"the signing key {path} is neither 64 hexadecimal digits nor 32 bytes")
    return key

"""The key of MAVLink 2 signatures, from a file that only its owner reads."""

import hashlib
import os
import stat

_MAX_BYTES = 4096


class KeyFileError(Exception):
    """A key that cannot be used; the message says why, and never what stands in the file."""


def read_key(path: str) -> bytes:
    """The key in `path`: 64 hexadecimal digits, or a passphrase, whose SHA-256 is the key. White space around
    it does not count.
    """
    try:
        with open(path, "rb") as file:
            permissions = stat.S_IMODE(os.fstat(file.fileno()).st_mode)
            content = file.read(_MAX_BYTES)
    except OSError as error:
        raise KeyFileError(f"cannot read the signing key {path}: {error.strerror}") from None
    if permissions & 0o077:
        raise KeyFileError(f"others may read the signing key {path}; run: chmod 600 {path}")
    try:
        text = content.decode().strip()
    except UnicodeDecodeError:
        raise KeyFileError(f"the signing key in {path} is no text") from None
    if not text:
        raise KeyFileError(f"the signing key in {path} is empty; `openssl rand -hex 32` makes one")
    if len(text) < 32 or any(c not in "0123456789abcdefABCDEF" for c in text):
        return hashlib.sha256(text.encode()).digest()
    if len(text) != 64:
        raise KeyFileError(f"the signing key in {path} has {len(text)} hexadecimal digits; a key has 64")
    return bytes.fromhex(text)

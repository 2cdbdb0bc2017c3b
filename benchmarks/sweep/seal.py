"""Seeds that are unknown while a version is written: only their hash is committed.

`python -m benchmarks.sweep.seal` draws new ones into ``build/sweep/sealed.txt``, which git
ignores, and prints the hash for ``HASH``. Once the version is scored, the file is committed as
``opened.txt`` beside this module, so that everybody can check the hash and run the same worlds.
"""

import hashlib
import secrets
from pathlib import Path

ROOT = Path(__file__).parents[2]
SEALED = ROOT / "build" / "sweep" / "sealed.txt"
OPENED = Path(__file__).with_name("opened.txt")
HASH = "979ce8dc816bd76d24530ce8216cc1c6ba2d46998cf309721153be09dee67834"
COUNT = 5
_SALT = 16
"""So many random bytes make the hash tell nothing about the seeds."""


def seeds() -> tuple[int, ...]:
    """Return the sealed seeds, none where they are not on this machine.

    Raises:
        ValueError: the file is not the one that the hash is of.
    """
    for path in (OPENED, SEALED):
        if path.exists():
            text = path.read_text(encoding="utf-8")
            if hashlib.sha256(text.encode()).hexdigest() != HASH:
                raise ValueError(f"{path}: its SHA-256 is not HASH in {__file__}; seal new seeds")
            return tuple(int(word) for word in text.split()[1:])
    return ()


def main() -> None:
    """Draw new seeds and print their hash."""
    numbers = [str(secrets.randbelow(2**31)) for _ in range(COUNT)]
    text = "\n".join([secrets.token_hex(_SALT), *numbers, ""])
    SEALED.parent.mkdir(parents=True, exist_ok=True)
    SEALED.write_text(text, encoding="utf-8")
    print(f'HASH = "{hashlib.sha256(text.encode()).hexdigest()}"  # remove opened.txt')


if __name__ == "__main__":
    main()

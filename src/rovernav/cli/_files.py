"""Where results go: a folder that can be written to, and no file that is read as well."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from pathlib import Path


def claim_folder(out: Path) -> None:
    """Make the folder for results before the work begins, so that no work is lost.

    Raises:
        FileError: It is a file, cannot be made, or cannot be written to.
    """
    from ..core import FileError

    try:
        out.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError):
        raise FileError(f"--out {out} is a file or lies below one; name a folder") from None
    except OSError as error:
        raise FileError(
            f"--out {out} cannot be made ({error.strerror}); name another folder"
        ) from error
    if not os.access(out, os.W_OK | os.X_OK):
        raise FileError(f"--out {out} may not be written to; name another folder")


def keep_apart(written: Mapping[str, Path], read: Sequence[Path | str | None]) -> None:
    """Make sure that no file is written twice, or read and written by the same command.

    Args:
        written: What will be written, by the option that says where.
        read: What the command reads; names that are no files do no harm.

    Raises:
        SettingError: The first file that would be lost.
    """
    from ..core import SettingError

    inputs = {os.path.realpath(path) for path in read if path is not None}
    seen: dict[str, str] = {}
    for option, path in written.items():
        real = os.path.realpath(path)
        if os.path.exists(real) and not os.path.isfile(real):
            continue  # a device such as /dev/null takes everything
        if real in inputs:
            raise SettingError(
                f"{path} is read by this command and would be written over; change {option}"
            )
        if real in seen:
            raise SettingError(f"{seen[real]} and {option} both name {path}; change one of them")
        seen[real] = option

"""Files from the browser: of known kinds, of bounded size, held in memory, named only for show."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from nicegui import events, ui

from ..core import FileError, RovernavError


def upload_button(
    label: str,
    *,
    kinds: Sequence[str],
    limit: int,
    on_file: Callable[[str, bytes], object],
    icon: str = "upload_file",
) -> ui.button:
    """A button that asks for one file.

    What `on_file` refuses with a `RovernavError` is told to the person in its words.

    Args:
        label: What the button says.
        kinds: Endings that are taken, like ``.csv``.
        limit: Bytes at most.
        on_file: Receives the name, to be shown and nothing else, and the content.
        icon: Its icon.
    """

    async def receive(event: events.UploadEventArguments) -> None:
        upload.reset()
        try:
            name = display_name(event.file.name)
            check_file(name, event.file.size(), kinds, limit)
            on_file(name, await event.file.read())
        except RovernavError as error:
            refuse(str(error))

    upload = (
        ui.upload(on_upload=receive, auto_upload=True, max_file_size=limit,
                  on_rejected=lambda: refuse(_wanted(kinds, limit)))
        .props(f'accept="{",".join(kinds)}" aria-hidden=true tabindex=-1')
        .classes("hidden")
    )  # fmt: skip
    return (
        ui.button(label, icon=icon, color=None)
        .props("flat dense no-caps")
        .on("click", js_handler=f"() => getElement({upload.id}).$refs.qRef.pickFiles()")
    )


def check_file(name: str, size: int, kinds: Sequence[str], limit: int) -> None:
    """Raise `FileError` for a file of another kind or too large a one."""
    if not name.lower().endswith(tuple(kinds)) or not 0 < size <= limit:
        raise FileError(f"{name}: {_wanted(kinds, limit)}")


def display_name(name: str) -> str:
    """A file name as it may be shown: its last part, what can be printed, not too long."""
    last = name.replace("\\", "/").rsplit("/", 1)[-1]
    plain = "".join(c for c in last if c.isprintable()).strip()
    return (plain if len(plain) <= 60 else f"{plain[:30]}…{plain[-29:]}") or "a file without a name"


def refuse(message: str) -> None:
    """Tell why something was not taken; the text is shown as text."""
    ui.notify(message, type="negative", position="top", timeout=8000, close_button="OK")


def _wanted(kinds: Sequence[str], limit: int) -> str:
    size = f"{limit / 1e6:g} MB" if limit >= 1e5 else f"{limit:,} bytes"
    return f"give a file that ends in {' or '.join(kinds)}, of at most {size}"

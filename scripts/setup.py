"""Make `.venv` with everything the project needs, once; when nothing has changed, do nothing.

Standard library only, and readable by an old Python, so that the advice below can be given.
A stamp, written last, tells what was installed; a mark, written first, tells that a run was killed.
"""

import contextlib
import fcntl
import hashlib
import importlib.util
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
VENV = ROOT / ".venv"
PYTHON = VENV / "bin" / "python"
STAMP = VENV / "rovernav-stamp"
UNFINISHED = VENV / "rovernav-unfinished"
LOG = VENV / "rovernav-setup.log"
EXTRAS = "cluster,studio,gym,ros,physics,test,dev,docs"
OLDEST, NEWEST = (3, 11), (3, 14)
FOREIGN = {  # what a person's shell may hold, and what would send packages elsewhere
    *("PIP_PREFIX", "PIP_TARGET", "PIP_USER"),
    *("PYTHONHOME", "PYTHONPATH", "__PYVENV_LAUNCHER__"),
}


def main() -> None:
    """Set up unless the stamp says that it is done; only one process at a time does it."""
    use_supported_python()
    if is_current():
        return
    with one_at_a_time():
        if not is_current():
            begun = time.monotonic()
            install()
            say(f"done in {time.monotonic() - begun:.0f} s")


def use_supported_python() -> None:
    """Go on under a supported Python: this one, or else one from the PATH."""
    if OLDEST <= sys.version_info[:2] <= NEWEST:
        return
    for minor in range(OLDEST[1], NEWEST[1] + 1):
        found = shutil.which(f"python3.{minor}")
        if found and works(found, minor):
            os.execv(found, [found, *sys.argv])
    stop(
        f"rovernav needs Python {dotted(OLDEST)} to {dotted(NEWEST)}; this is "
        f"{dotted(sys.version_info[:3])} ({sys.executable}), and no other is on the PATH.\n"
        "Install one, or name it: make PYTHON=/path/to/python3.12"
    )


def works(python: str, minor: int) -> bool:
    """Whether `python` starts and is Python 3.`minor` (a version manager's shim may refuse)."""
    code = f"import sys; sys.exit(sys.version_info[:2] != (3, {minor}))"
    return subprocess.run([python, "-c", code], capture_output=True, check=False).returncode == 0


def interpreter() -> str:
    """What `.venv` is made from: it has to be made anew where this differs."""
    return digest(sys.version.encode(), str(ROOT).encode())


def wanted() -> str:
    """What the stamp says after a set-up from the present files."""
    inputs = (ROOT / "pyproject.toml", ROOT / "constraints.txt", Path(__file__))
    return interpreter() + " " + digest(*(path.read_bytes() for path in inputs))


def digest(*parts: bytes) -> str:
    """One hash of all `parts` and their lengths."""
    total = hashlib.sha256()
    for part in parts:
        total.update(b"%d:" % len(part) + part)
    return total.hexdigest()[:32]


def stamp() -> str:
    """The stamp of the last complete set-up, or nothing."""
    try:
        return STAMP.read_text()
    except OSError:
        return ""


def is_current() -> bool:
    """Whether `.venv` is complete and from the present files."""
    return stamp() == wanted() and not UNFINISHED.exists() and PYTHON.exists()


@contextlib.contextmanager
def one_at_a_time():
    """Hold a lock that ends with this process and the steps it started, however they end."""
    with (ROOT / "pyproject.toml").open("rb") as file:
        os.set_inheritable(file.fileno(), True)
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            say("waiting for another set-up of this folder")
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


def install() -> None:
    """Bring `.venv` from whatever it is to complete and stamped."""
    from_scratch = must_start_from_scratch()
    VENV.mkdir(exist_ok=True)
    UNFINISHED.touch()
    with contextlib.suppress(FileNotFoundError):
        STAMP.unlink()
    if from_scratch:
        make_venv()
    say("upgrading pip")
    pip("install", "--upgrade", "pip")
    say(f"installing rovernav[{EXTRAS}] (about a minute the first time)")
    pip("install", "--editable", f".[{EXTRAS}]")
    draft = STAMP.with_suffix(".new")
    draft.write_text(wanted())
    UNFINISHED.unlink()
    draft.replace(STAMP)


def must_start_from_scratch() -> bool:
    """False where the packages of a whole `.venv` can be brought up to date in place."""
    if UNFINISHED.exists() or not VENV.exists() or not any(VENV.iterdir()):
        return True
    if stamp():
        return stamp().split()[0] != interpreter() or not PYTHON.exists()
    if PYTHON.exists() and works(str(PYTHON), sys.version_info[1]):
        return False
    return stop(
        f"{VENV} is there, but was not made by this script from "
        f"Python {dotted(sys.version_info[:2])}.\n"
        "Move it away or remove it, then run make again."
    )


def make_venv() -> None:
    """An empty `.venv` from the Python that runs this; the mark of an unfinished run stays."""
    if importlib.util.find_spec("ensurepip") is None:
        name = f"python{dotted(sys.version_info[:2])}-venv"
        stop(
            "this Python cannot make environments (it has no ensurepip).\n"
            f"On Debian and Ubuntu: sudo apt install python3-venv (or {name}), then run make again."
        )
    say(f"making .venv with Python {dotted(sys.version_info[:3])}")
    for path in VENV.iterdir():
        if path != UNFINISHED:
            shutil.rmtree(path) if path.is_dir() and not path.is_symlink() else path.unlink()
    step([getattr(sys, "_base_executable", sys.executable), "-m", "venv", str(VENV)])


def pip(*arguments: str) -> None:
    """Run the environment's pip; after an orderly failure the next run goes on from here."""
    try:
        step([str(PYTHON), "-m", "pip", *arguments])
    except SystemExit:
        UNFINISHED.unlink()
        raise


def step(command: list) -> None:
    """Run `command` in the project's folder; its words go to the log, and are shown if it fails."""
    environment = {name: value for name, value in os.environ.items() if name not in FOREIGN}
    environment.update(
        PIP_BUILD_CONSTRAINT="constraints.txt",
        PIP_CONSTRAINT="constraints.txt",
        PIP_DISABLE_PIP_VERSION_CHECK="1",
        PIP_NO_INPUT="1",
    )
    with LOG.open("wb") as log:
        failed = subprocess.call(
            command,
            cwd=ROOT,
            env=environment,
            stdout=log,
            stderr=subprocess.STDOUT,
            close_fds=False,  # an orphaned step keeps the lock
        )
    if failed:
        last = LOG.read_text(errors="replace").rstrip().splitlines()[-12:]
        stop("\n".join([*last, f"failed: {' '.join(command)}", f"all it said is in {LOG}"]))


def dotted(version: tuple) -> str:
    """(3, 11) as 3.11."""
    return ".".join(str(number) for number in version)


def say(text: str) -> None:
    """One line for each step."""
    print(f"setup: {text}", flush=True)


def stop(text: str) -> bool:
    """End with a message and exit code 1."""
    sys.exit("setup: " + text)


if __name__ == "__main__":
    main()

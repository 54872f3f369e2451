"""`rovernav sweep`: thousands of trainings at once."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter

from ._console import note, print_json, print_table, progress_bar, say, say_files
from ._files import claim_folder, keep_apart
from ._numbers import numbers, whole_numbers
from ._options import Json, Out, SeedValue, Whole
from ._subject import USUAL, read_table
from ._workers import Place

if TYPE_CHECKING:
    from ..learn import Patterns, SettingScore, SweepProgress, SweepResult, SweepSettings

KEPT = "sweep.members"
"""The file that a sweep is resumed from."""
FILES = ("sweep.csv", "settings.csv", "sweep.png", "best.safetensors")
MOST_SHOWN = 1000
LISTED = 30
"""Settings that are printed; more are only in the file."""


def sweep(
    patterns: Annotated[str, Parameter(help="CSV file, or a shipped table such as bassil-v1.")],
    /,
    *,
    topology: Annotated[str, Parameter(help="Units per layer, inputs first.")] = USUAL,
    activations: Annotated[
        str | None,
        Parameter(help="One per layer after the inputs; default sigmoid, the outputs linear."),
    ] = None,
    eta: Annotated[
        str,
        Parameter(help="Learning rates: a list 0.1,0.2, a range 0.05..0.5 (10 of them) or /20."),
    ] = "0.25",
    momentum: Annotated[
        str, Parameter(help="Shares of the last change repeated; written like --eta.")
    ] = "0.5",
    seeds: Annotated[Whole, Parameter(help="Networks for each eta and momentum.")] = 1000,
    seed: Annotated[SeedValue, Parameter(help="Seed of the first one; the others follow.")] = 0,
    tolerance: Annotated[
        float, Parameter(help="A network ends once every |error| is below; 0 does all epochs.")
    ] = 0.01,
    epochs: Annotated[Whole, Parameter(help="Epochs of a network at most.")] = 5000,
    rule: Annotated[str, Parameter(help="paper or textbook.")] = "paper",
    order: Annotated[str, Parameter(help="cyclic or shuffled.")] = "cyclic",
    place: Place | None = None,
    members: Annotated[
        str | None,
        Parameter(help="Also tell the weights of these members, by their numbers: 0,17."),
    ] = None,
    resume: Annotated[
        bool,
        Parameter(
            negative="", show_default=False, help="Go on with the sweep in --out, to the same bits."
        ),
    ] = False,
    out: Out = Path("rovernav-sweep"),
    json: Json = False,
) -> int:
    """Train a network for each eta, momentum and seed, thousands at once.

    Each ends with the bits that rovernav train gives it alone. Writes sweep.csv (a line for each
    network), settings.csv, sweep.png and best.safetensors. Finished networks are kept in the
    folder: after Ctrl-C or a crash the same command with --resume goes on.

    Example: rovernav sweep bassil-v1 --eta 0.05..0.5 --momentum 0,0.5,0.9
    """
    from ..learn import SweepStore
    from ..learn import sweep as run

    with progress_bar("sweeping") as update:

        def on_event(event: SweepProgress) -> None:
            words = f"{event.members:,} of {event.of:,}, {event.rate:,.0f} a second"
            update(event.members / event.of, f"{words}, {event.solved:,} solved")

        from ..learn import SweepSettings
        from ..nets import parse_topology

        settings = SweepSettings(
            topology=parse_topology(topology),
            activations=tuple(a.strip() for a in activations.split(",")) if activations else (),
            etas=numbers("--eta", eta),
            momenta=numbers("--momentum", momentum),
            seeds=seeds, first_seed=seed, rule=rule, tolerance=tolerance, epochs=epochs,
            order=order,
        )  # fmt: skip
        shown = _shown(members, settings)
        table = read_table(patterns, settings.topology[0])
        settings.check_fit(table)
        files = [out / name for name in FILES]
        keep_apart({f"--out ({path.name})": path for path in (*files, out / KEPT)}, [patterns])
        claim_folder(out)
        with (
            (place or Place()).executor(usual=0, threads=True) as executor,
            SweepStore.open(out / KEPT, settings, table, resume=resume) as store,
        ):
            if resume:
                note(f"Resumed: {store.members:,} of {settings.members:,} members were kept.")
            result = run(table, settings, executor=executor, store=store, on_event=on_event)
            if result.finished:
                _write(files, result, table, settings, store)
    report = _report(result, settings, len(table.x))
    if result.finished:
        report["weights"] = _weights(table, settings, shown)
        report["files"] = files
    if json:
        print_json(report)
    elif result.finished:
        _print(report, result, table)
    if not result.finished:
        note(
            f"Interrupted; {result.members:,} of {settings.members:,} members are kept in {out}. "
            "Go on with the same command and --resume."
        )
    return 0 if result.finished else 130


def _shown(members: str | None, settings: SweepSettings) -> list[int]:
    """The members whose weights shall be told."""
    from ..core import SettingError

    if members is None:
        return []
    wanted = whole_numbers("--members", members)
    if len(wanted) > MOST_SHOWN:
        raise SettingError(f"--members takes up to {MOST_SHOWN:,} numbers, got {len(wanted):,}")
    for number in wanted:
        if not 0 <= number < settings.members:
            raise SettingError(
                f"there is no member {number}; this sweep has members 0 to {settings.members - 1}"
            )
    return wanted


def _write(
    files: list[Path],
    result: SweepResult,
    table: Patterns,
    settings: SweepSettings,
    store: Any,
) -> None:
    from ..core import FileError
    from ..learn import describe, train_members, write_members_csv, write_settings_csv
    from ..nets import save_network, topology_text
    from ..show import draw_sweep

    best = result.best
    assert best is not None  # a finished sweep has members
    (again,) = train_members(table, settings, [best.member])
    if (again.epoch, again.stop) != (best.epochs, best.stop):
        raise FileError(
            f"{files[0].parent / KEPT} was begun on a machine that rounds otherwise; "
            "begin anew in another folder"
        )
    members_csv, settings_csv, picture, network = files
    write_members_csv(store, settings, len(table.x), members_csv)
    write_settings_csv(result, settings_csv)
    title = f"{settings.members:,} {topology_text(settings.topology)} networks on {table.source}"
    draw_sweep(result, picture, tolerance=settings.tolerance, title=title)
    save_network(describe(again, table, settings.online(best.member)), network)


def _weights(table: Patterns, settings: SweepSettings, shown: list[int]) -> list[dict[str, Any]]:
    """The members that were asked for, with their weights."""
    from ..learn import train_members
    from ..nets import weights_sha256

    out: list[dict[str, Any]] = []
    for number, ended in zip(shown, train_members(table, settings, shown), strict=True):
        eta, momentum = settings.rate(number)
        out.append({
            "member": number, "eta": eta, "momentum": momentum, "seed": settings.seed(number),
            "stop": str(ended.stop), "epochs": ended.epoch, "updates": ended.updates,
            "weights": ended.network.parameters, "weights_sha256": weights_sha256(ended.network),
        })  # fmt: skip
    return out


def _report(result: SweepResult, settings: SweepSettings, patterns: int) -> dict[str, Any]:
    from ..nets import topology_text

    rows = [dataclasses.asdict(score) for score in result.settings]
    return {
        "stop": "finished" if result.finished else "interrupted",
        "members": result.members,
        "of": settings.members,
        "updates": result.updates,
        "seconds": result.seconds,
        "ns_per_update": result.ns_per_update,
        "workers": result.workers,
        "solved": result.solved,
        "diverged": result.diverged,
        "patterns": patterns,
        "topology": topology_text(settings.topology),
        "tolerance": settings.tolerance,
        "settings": rows,
        "best": None if result.best is None else dataclasses.asdict(result.best),
    }


def _print(report: dict[str, Any], result: SweepResult, table: Patterns) -> None:
    took = f"{result.updates:,} updates, {result.seconds:.2f} s"
    if result.updates_now:
        took += f", {result.ns_per_update:.1f} ns each"
    say(f"{result.members:,} networks trained: {took}.")
    if report["tolerance"] > 0.0:
        say(f"{result.solved:,} met the tolerance of {report['tolerance']:g}, "
            f"{result.diverged:,} diverged.")  # fmt: skip
    else:
        say(f"All epochs were done, without a tolerance; {result.diverged:,} diverged.")
    _print_settings(result.settings, report["tolerance"])
    best = result.best
    assert best is not None
    say(f"Best: member {best.member}, eta {best.eta!r}, momentum {best.momentum!r}, seed "
        f"{best.seed}: {best.epochs:,} epochs, largest |error| {best.max_error:.4g}.")  # fmt: skip
    for one in report["weights"]:
        say(f"Member {one['member']}: eta {one['eta']!r}, momentum {one['momentum']!r}, "
            f"seed {one['seed']}, {one['epochs']:,} epochs, weights:")  # fmt: skip
        say(f"  {one['weights_sha256']}")
    say_files(report["files"])


def _print_settings(scores: tuple[SettingScore, ...], tolerance: float) -> None:
    """The settings as a table: all of them, or the best where there are many."""
    title = "Each eta and momentum:"
    if len(scores) > LISTED:
        title = f"The best {LISTED} of {len(scores):,} settings (all are in settings.csv):"
        scores = tuple(sorted(scores, key=_rank)[:LISTED])
    if tolerance > 0.0:
        columns = ("eta", "momentum", "solved", "95 % range", "epochs", "quartiles", "diverged")
    else:
        columns = ("eta", "momentum", "diverged", "least error")
    rows = [_cells(score, tolerance) for score in scores]
    print_table(title, columns, rows)


def _cells(s: SettingScore, tolerance: float) -> tuple[str, ...]:
    """A line of the table; epochs are the median of those that met the tolerance."""
    rates, diverged = (f"{s.eta:g}", f"{s.momentum:g}"), f"{s.diverged / s.members:.1%}"
    if tolerance == 0.0:
        return *rates, diverged, f"{s.least_error:.3g}"
    low, middle, high = s.epochs
    spread = f"{_count(low)}-{_count(high)}" if s.solved else "-"
    share = f"{100 * s.low:.1f}-{100 * s.high:.1f}"
    return *rates, f"{s.success:.1%}", share, _count(middle), spread, diverged


def _rank(score: SettingScore) -> tuple[float, float, float]:
    median = score.epochs[1]
    return -score.success, math.inf if math.isnan(median) else median, score.least_error


def _count(number: float) -> str:
    return "-" if math.isnan(number) else f"{number:,.0f}"

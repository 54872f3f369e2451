"""One route across a large map of costs: rovernav, and what one would take instead."""

from harness.model import Peer, Target, Workload

from . import grids, open_ground, ours, task

OURS = "rovernav, any_angle"
PEERS = {
    OURS: ours.any_angle,
    "rovernav, any_angle, whole map": ours.whole_map,
    "rovernav, shortest": ours.shortest,
    "pyastar2d": grids.pyastar2d,
    "scikit-fmm, order 2 and descent": open_ground.scikit_fmm,
    "scikit-image, MCP_Geometric": grids.skimage,
    "SciPy, csgraph.dijkstra": grids.scipy,
    "dijkstra3d": grids.dijkstra3d,
    "xarray-spatial, a_star_search": grids.xarray_spatial,
    "networkx, astar_path": grids.networkx,
    "OMPL, RRT* for 5 s": open_ground.ompl,
}


def _nothing(_group: str, _size: int) -> None:
    return None


def workload(name: str, of: str, what: str) -> Workload:
    """One table: one route over one of the maps."""
    return Workload(
        name=name,
        title=(
            f"One route across 4096 x 4096 cells of {what}; every path is judged by the same line "
            "integral, and its cost is given over that of the best path known."
        ),
        unit="s",
        peers=tuple(
            Peer(name=peer, build=task.one_route(of, prepare)) for peer, prepare in PEERS.items()
        ),
        targets=(
            Target(row=OURS, limit=1.0),
            Target(row="pyastar2d", against=OURS, limit=2.7, at_least=True),
            Target(row="scikit-fmm, order 2 and descent", against=OURS, limit=5.0, at_least=True),
            Target(row="scikit-image, MCP_Geometric", against=OURS, limit=5.0, at_least=True),
        ),
        anchors={OURS: "any_angle"},
        size=4096,
        quick=512,
        scale=1.0,
        check="cost / best",
        expected=_nothing,
        tolerance=0.0,
        one_core=True,
    )


WORKLOAD = workload("plan", "fractal", "fractal ground")

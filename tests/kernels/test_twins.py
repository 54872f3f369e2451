"""Every kernel that a simulated drive uses has a test against something slower and simpler.

A new kernel needs an entry here, and with it such a test: a twin in plain Python (tests/naive), or
another library that decides. Helpers (with an underscore) belong to the kernels that call them.
"""

from __future__ import annotations

import ast
from pathlib import Path

TWINS = {
    "kernels/test_drive.py::test_a_differential_drive_follows_its_arc": "drive.differential",
    "kernels/test_drive.py::test_a_goal_is_turned_into_the_rovers_frame": "drive.goal_in_body",
    "kernels/test_drive.py::test_a_step_ends_where_and_as_plain_python_says": "drive.meet",
    "kernels/test_drive.py::test_channels_stand_side_by_side": "drive.side_by_side",
    "kernels/test_drive.py::test_contact_and_sight_are_with_ones_own_world": (
        "drive.clear_sight drive.first_contact"
    ),
    "kernels/test_drive.py::test_off_line_is_farther_than_the_threshold_from_the_whole_line": (
        "drive.off_line"
    ),
    "kernels/test_drive.py::test_outputs_become_speeds_that_stop_at_a_goal_in_sight": (
        "drive.axis_speeds"
    ),
    "kernels/test_drive.py::test_two_axes_move_along_and_across_the_heading": "drive.two_axis",
    "kernels/test_footprint.py::test_a_world_is_seen_with_all_its_obstacles": (
        "footprint.meets_world"
    ),
    "kernels/test_footprint.py::test_boxes_at_rest": "footprint.holds footprint.meets_box",
    "kernels/test_footprint.py::test_cells_at_rest": "footprint.meets_cells",
    "kernels/test_footprint.py::test_discs_at_rest": "footprint.meets_disc",
    "kernels/test_footprint.py::test_hulls_are_those_of_shapely": "footprint.hull_of",
    "kernels/test_footprint.py::test_polygons_at_rest": "footprint.meets_shape",
    "kernels/test_footprint.py::test_what_a_moving_footprint_sweeps": "footprint.spread_of",
    "kernels/test_geometry.py::test_boxes_are_met_where_exact_arithmetic_meets_them": (
        "geometry.first_box geometry.side_of"
    ),
    "kernels/test_geometry.py::test_cells_are_met_where_exact_arithmetic_meets_them": (
        "geometry.first_cell"
    ),
    "kernels/test_geometry.py::test_distances_are_exact": (
        "geometry.segment_box geometry.segment_point"
    ),
    "kernels/test_geometry.py::test_first_boxes_takes_the_nearest_of_its_own": (
        "geometry.first_boxes"
    ),
    "kernels/test_geometry.py::test_the_closest_cell_is_the_closest_of_all": (
        "geometry.closest_cell"
    ),
    "kernels/test_rays.py::test_a_beam_ends_at_the_nearest_of_all_cells": "rays.range_fan",
    "kernels/test_rays.py::test_the_table_tells_the_nearest_cell_of_each_cone": (
        "rays.free_cones rays.table_size"
    ),
    "kernels/test_ridge_fan.py::test_entries_are_never_below_the_ground_of_their_windows": (
        "ridge_tops.blocks_of ridge_tops.fill_tops"
    ),
    "kernels/test_ridge_fan.py::test_the_table_changes_no_bit": "ridge_fan.ground_fan",
    "kernels/test_ridges.py::test_a_ridge_hides_what_lies_behind": "ridges.in_view ridges.rise_fan",
    "kernels/test_ridges.py::test_blocks_change_no_bit": "ridges.tops_of",
    "kernels/test_ridges.py::test_ground_is_met_where_trying_every_patch_meets_it": (
        "ridges.first_rise ridges.walk"
    ),
    "kernels/test_team.py::test_nobody_goes_on_before_all_are_there": "team.meet",
    "kernels/test_shapes.py::test_contact_is_where_dense_samples_find_it": (
        "shapes.first_shape shapes.inside"
    ),
    "kernels/test_shapes.py::test_distances_are_those_of_dense_samples": "shapes.segment_shape",
    "kernels/test_shapes.py::test_each_rover_meets_the_shapes_of_its_own_world": (
        "shapes.first_shapes"
    ),
    "mapping/test_elevation.py::test_the_map_is_that_of_plain_python": (
        "elevation.at_cell elevation.fuse elevation.judge"
    ),
    "mapping/test_drops.py::test_drops_are_taken_in_as_in_plain_python": "drops.take_drops",
    "mapping/test_local_map.py::test_bearing": "fan.bearing",
    "mapping/test_local_map.py::test_the_map_is_a_set_of_cells_that_forgets_what_lies_beyond_its_edge": (  # noqa: E501
        "fan.mark fan.roll fan.window"
    ),
    "mapping/test_map_twins.py::test_a_patch_is_laid_where_it_fits_as_in_plain_python": (
        "elevation.level"
    ),
    "mapping/test_map_twins.py::test_doubt_grows_as_in_plain_python": "elevation.inflate",
    "mapping/test_map_twins.py::test_hazards_grow_as_in_plain_python": "elevation.grow",
    "mapping/test_map_twins.py::test_rays_of_a_map_are_those_of_plain_python": "fan.around",
    "mapping/test_map_twins.py::test_what_leaves_is_forgotten_as_in_plain_python": (
        "elevation.forget"
    ),
    "nets/test_drawn.py::test_any_pair_of_a_key_and_a_number": "draws.uniform_pairs",
    "nets/test_drawn.py::test_any_seed": "draws.uniform",
    "rover/test_hazards.py::test_layers_of_a_plane": "traction.drive_layer traction.lean",
    "rover/test_settle.py::test_settling_equals_newtons_method": (
        "settle.settle_one settle.verdict settle.wheel_places standing.clearance_of "
        "standing.fetch_ground standing.settle standing.step_under"
    ),
    "rover/test_settle.py::test_wheel_centres_equal_their_twin": "surface.wheel_centres",
    "rover/test_traction.py::test_cost_equals_its_twin": "traction.drive_all traction.drive_edge",
    "sim/test_ground_fan.py::test_readings_are_those_of_a_twin_that_tries_every_patch": (
        "obstacle_fan.obstacle_fan ridge_fan.end_of ridge_fan.looks_of"
    ),
    "sim/test_noise.py::test_keys_and_draws_are_those_of_plain_python": (
        "field.mixed noise.keys noise.share"
    ),
    "sim/test_noise.py::test_ranges_are_spoilt_as_in_plain_python": "noise.spoil",
    "sim/test_noise.py::test_voltages_are_those_of_plain_python": "noise.voltage",
    "sim/test_odometry.py::test_estimates_are_those_of_plain_python": (
        "odometry.advance odometry.wrap"
    ),
    "sim/test_sensor_twins.py::test_hole_sensors_equal_their_twin": (
        "noise.infrared patches.look_down patches.turned"
    ),
    "sim/test_sensor_twins.py::test_patches_equal_their_twin": (
        "odometry.base patches.seen_patch patches.under surface.height_at"
    ),
    "sim/test_sensor_twins.py::test_tilt_and_cones_equal_their_twins": (
        "noise.nearest_of noise.tilted"
    ),
    "sim/test_step_twin.py::test_a_whole_step_equals_its_twin": (
        "contact.first_touch footprint.along_arc traction.pull_of traction.slips "
        "wheels.allowed wheels.responded wheels.wheel_speeds"
    ),
    "sim/test_step_twin.py::test_every_way_to_end_is_decided_as_by_the_twin": "body.move",
    "terrain/test_field.py::test_grain_equals_its_twin": "field.add_grain field.deviate",
    "terrain/test_field.py::test_waves_equal_their_twin": "field.add_waves field.spline",
    "terrain/test_rocks.py::test_rocks_equal_their_twin": "rocks.raise_rocks",
}
"""Test, in tests/: the kernels it holds to account."""
OTHERS = ("kernels/test_footprint.py", "mapping/test_local_map.py", "rover/test_hazards.py")
"""Files whose tests need not run as plain Python: shapely or closed forms decide there."""


def used(kernels: Path) -> set[str]:
    """Files of kernels that rooms of a drive import, and those that these import."""
    rooms = kernels.parent
    todo = {name for room in ("sim", "mapping") for path in (rooms / room).glob("*.py")
            for name in _imports(path, kernels, level=2)}  # fmt: skip
    done: set[str] = set()
    while todo - done:
        name = (todo - done).pop()
        done.add(name)
        todo |= _imports(kernels / f"{name}.py", kernels, level=1)
    return done


def _imports(path: Path, kernels: Path, *, level: int) -> set[str]:
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.level == level:
            parts = (node.module or "").split(".")
            if level == 2 and parts.pop(0) != "kernels":
                continue
            found |= {alias.name for alias in node.names} if parts in ([], [""]) else {parts[0]}
    return {name for name in found if (kernels / f"{name}.py").exists() and name != "_jit"}


def public(path: Path) -> set[str]:
    """The kernels of a file that others may call."""
    return {
        f"{path.stem}.{node.name}"
        for node in ast.parse(path.read_text(encoding="utf-8")).body
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
        if any(ast.unparse(mark).startswith("kernel(") for mark in node.decorator_list)
    }


def test_every_kernel_of_a_drive_has_a_twin(root: Path) -> None:
    kernels = root / "src" / "rovernav" / "kernels"
    there = set[str]().union(*(public(kernels / f"{name}.py") for name in used(kernels)))
    listed = [kernel for words in TWINS.values() for kernel in words.split()]
    assert len(there) > 60
    assert there - set(listed) == set(), "new kernels need a twin and a line in TWINS"
    assert len(listed) == len(set(listed))


def test_the_tests_are_there_and_run_in_the_lanes_of_kernels(root: Path) -> None:
    for place in TWINS:
        file, name = place.split("::")
        tree = ast.parse((root / "tests" / file).read_text(encoding="utf-8"))
        tests = {node.name: node for node in tree.body if isinstance(node, ast.FunctionDef)}
        assert name in tests, place
        marks = [ast.unparse(mark) for mark in tests[name].decorator_list]
        whole = any(
            isinstance(node, ast.Assign) and ast.unparse(node) == "pytestmark = pytest.mark.kernels"
            for node in tree.body
        )
        assert whole or "pytest.mark.kernels" in marks or file in OTHERS, place

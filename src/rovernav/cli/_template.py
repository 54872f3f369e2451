"""`rovernav template`: a scenario file to start from."""

from __future__ import annotations

from ._console import print_json, say
from ._options import Json

TEMPLATE = """\
# A drive for rovernav: save this as drive.yaml, then: rovernav drive drive.yaml
# Every key is here; those with a default may be left out. Lengths are in metres.

# The ground: flat unless an elevation model is named or ground is generated.
# terrain: yard.tif          # GeoTIFF, .npy, .png, meta.json; or a ROS map's .yaml; beside
                             # this file
# cell: 0.1                  # side of a cell, only for files that do not say it (.npy)
# heights: [-110, 8.5]       # lowest and highest height of the greys, only for pictures
# south_first: true          # row 0 of a table or array is the south edge
# generate:                  # hills and craters made from the seed; local metres
#   name: hills
#   side_m: 50.0
#   cell_m: 0.2
#   relief_m: 5.0            # highest minus lowest height, before the craters come
#   hurst: 0.9               # 0.5 is jagged, 0.9 smooth
#   craters: 40
# rocks: 0.05                # scatter rocks over this share of the ground, by seed

# Obstacles on it, in the frame of from and to; a rover keeps its radius away from them.
boxes:                       # rectangles x0, y0, x1, y1
  - [4.365, -1.0, 7.365, 3.75]
# circles: [[9.0, 1.5, 0.5]] # x, y, radius
# polygons:                  # corners x, y
#   - [[2, -3], [3, -2], [2, -2]]

# Where to.
from: [0.0, 0.0]             # x, y; may be negative
to: [11.73, 0.0]
frame: crs                   # crs: the terrain's own coordinates; local: metres east and north of
                             # its south-west corner; pixel: column and row from its top left

# Who drives.
rover: paper-point           # a rover file, my-rover.yaml, or one of the presets
                          # curiosity, jackal, mer, paper-point, perseverance, research, sojourner
# body: true                 # drive a body that settles on the ground, slips and spends energy;
                             # needs ground and a rover with wheels
# soil: loose-sand           # soil under a body; the rover's own where not given
# slip_spread: 0.3           # slip differs by up to this share from drive to drive, by seed
controller: bassil           # bassil: the paper's network; neural: the shipped driver, for rovers
                             # with differential drive; goal-seeker; planner; a plug-in; or a
                             # network file
# sensing: ideal             # what it sees with: ideal; lidar or sonar: a fan with noise; stereo:
                             # heights, from which it makes its own map of where it can go;
                             # stereo+holes: infra-red that looks down besides
# drift: true                # it goes by odometry that drifts, instead of its true pose
# carry: [my-sensor]         # sensors of installed plug-ins that it carries besides its own
# route: way.geojson         # follow this line, from rovernav route; or plan, for one planned here

# How long, and what is random.
# time_limit_s: 60.0         # longest drive; five times the straight line where not given
seed: 0                      # same seed, same drive
"""


def template(*, json: Json = False) -> int:
    """Print a complete scenario file with comments, ready to be saved and driven.

    Example: rovernav template > drive.yaml
    """
    if json:
        import yaml

        print_json(yaml.safe_load(TEMPLATE))
    else:
        say(TEMPLATE.rstrip("\n"))
    return 0

"""The studio: training engine and rover simulator as a local web page.

Sessions, trainings, drives and the library of runs are plain classes that know no browser; pages
read them and call the same public functions as the command line. Only `serve` opens a port.
"""

from ._library import Library, Run
from ._options import Options
from ._server import serve
from ._session import Session, Sessions
from ._training import TrainModel

__all__ = ["Library", "Options", "Run", "Session", "Sessions", "TrainModel", "serve"]

"""The online kernel for ONE topology: its loops written out, every weight in a register.

The source of the kernel is generated from the topology, kept as a readable file in the kernel
cache and compiled once. It does the operations of `backprop.train` in the same order, so the
weights have the same bits; it is only faster (measured in ``benchmarks/``).
"""

from __future__ import annotations

import functools
import importlib.util
import secrets
import sys
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

from ._jit import OPTIONS, cache_folder, cached
from .backprop import TEXTBOOK
from .network import RELU, SIGMOID, TANH

MAX_WEIGHTS = 100
"""Networks with more weights gain nothing from being written out and compile slowly."""

_OUTPUT = {SIGMOID: "sigmoid({s})", TANH: "tanh({s})", RELU: "relu({s})"}
_SLOPE = {
    SIGMOID: "{o} * (1.0 - {o})",
    TANH: "fma(-{o}, {o}, 1.0)",
    RELU: "step({o})",
}
Layers = tuple[tuple[int, int, int], ...]
ARITHMETIC = "from rovernav.kernels.arithmetic import fma, relu, sigmoid, step, tanh"
"""What the statements below call."""


@functools.cache
def frozen_train(layers: Layers, rule: int) -> Callable[..., tuple[int, bool]]:
    """The compiled kernel for these layers and this rule; the arguments are `backprop.train`'s.

    `record` must be empty: recording weights is the generic kernel's work.
    """
    name = "x".join(f"{i}_{u}_{code}" for i, u, code in layers)
    source = "\n".join(_module(layers, rule)) + "\n"
    return cached(written(f"frozen_{name}_{rule}", source).train, OPTIONS)


def written(name: str, source: str) -> Any:
    """A generated module; a file in the kernel cache where possible."""
    folder = cache_folder()
    if folder is None:
        space: dict[str, Any] = {"__name__": f"rovernav.kernels.{name}"}
        exec(source, space)  # generated here, from whole numbers alone
        return SimpleNamespace(**space)
    path = folder / f"{name}.py"
    if not path.exists() or path.read_bytes() != source.encode():
        scratch = path.with_suffix(f".{secrets.token_hex(4)}.tmp")
        scratch.write_bytes(source.encode())
        scratch.replace(path)
    spec = importlib.util.spec_from_file_location(f"rovernav.kernels.{name}", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # Numba looks there when it loads the compiled code
    spec.loader.exec_module(module)
    return module


def _module(layers: Layers, rule: int) -> Iterator[str]:
    weights = _starts(layers)[-1]
    yield "import numpy as np"
    yield ARITHMETIC
    yield "from rovernav.kernels.backprop import shuffle"
    yield "from rovernav.kernels.network import all_within"
    yield ""
    yield "def train(layers, w, v, x, y, s, record):"
    yield "    order = np.arange(x.shape[0])"
    yield "    eta, mu = s.eta, s.momentum"
    for q in range(weights):
        yield f"    w{q} = w[{q}]; v{q} = v[{q}]"
    yield "    for done in range(s.epochs):"
    yield "        if s.tolerance > 0.0:"
    yield from (f"            w[{q}] = w{q}; v[{q}] = v{q}" for q in range(weights))
    yield "            if all_within(layers, w, x, y, s.tolerance):"
    yield "                return done, True"
    yield "        if s.seed >= 0:"
    yield "            shuffle(order, s.seed, s.epoch + done)"
    yield "        for p in order:"
    yield from ("            " + line for line in update(layers, rule))
    yield from (f"    w[{q}] = w{q}; v[{q}] = v{q}" for q in range(weights))
    yield "    return s.epochs, False"


def update(layers: Layers, rule: int, x: str = "x[p, {i}]", y: str = "y[p, {k}]") -> Iterator[str]:
    """Statements that change the weights for pattern p; `x` and `y` say how it is read."""
    starts = _starts(layers)
    yield from forward(layers, x)
    last = len(layers) - 1
    for k in range(layers[last][1]):
        yield f"error = {y.format(k=k)} - o{last}_{k}"
        yield from _signal(layers[last][2], last, k)
    for layer in range(last, -1, -1):
        back = list(_back(layers, starts, layer)) if layer > 0 else []
        change = list(_change(layers[layer], starts[layer], layer))
        yield from (back + change if rule == TEXTBOOK else change + back)


def forward(layers: Layers, x: str = "x[p, {i}]") -> Iterator[str]:
    """Statements that run pattern p through the network; unit k of the last layer is o{last}_k."""
    starts = _starts(layers)
    for i in range(layers[0][0]):
        yield f"x{i} = {x.format(i=i)}"
    for layer, (inputs, units, code) in enumerate(layers):
        for unit in range(units):
            at = starts[layer] + unit * (inputs + 1)
            yield f"s{unit} = w{at + inputs}"
            for i in range(inputs):
                yield f"s{unit} = fma(w{at + i}, {_source(layer, i)}, s{unit})"
            yield f"o{layer}_{unit} = {_OUTPUT.get(code, '{s}').format(s=f's{unit}')}"


def _starts(layers: Layers) -> list[int]:
    """Where each layer's weights begin, and where the last one's end."""
    starts = [0]
    for inputs, units, _ in layers:
        starts.append(starts[-1] + units * (inputs + 1))
    return starts


def _signal(code: int, layer: int, unit: int) -> Iterator[str]:
    """Error signal d and step g of a unit, from its summed `error`."""
    if code in _SLOPE:
        yield f"rise = {_SLOPE[code].format(o=f'o{layer}_{unit}')}"
        yield f"d{layer}_{unit} = rise * error"
        yield f"g{layer}_{unit} = (eta * rise) * error"
    else:
        yield f"d{layer}_{unit} = error"
        yield f"g{layer}_{unit} = eta * error"


def _back(layers: Layers, starts: list[int], layer: int) -> Iterator[str]:
    inputs, units, _ = layers[layer]
    for i in range(inputs):
        yield f"error = d{layer}_0 * w{starts[layer] + i}"
        for k in range(1, units):
            yield f"error = fma(d{layer}_{k}, w{starts[layer] + k * (inputs + 1) + i}, error)"
        yield from _signal(layers[layer - 1][2], layer - 1, i)


def _change(shape: tuple[int, int, int], start: int, layer: int) -> Iterator[str]:
    inputs, units, _ = shape
    for unit in range(units):
        g = f"g{layer}_{unit}"
        for i in range(inputs):
            q = start + unit * (inputs + 1) + i
            yield f"m = mu * v{q}"
            yield f"w{q} = fma({g}, {_source(layer, i)}, w{q} + m)"
            yield f"v{q} = fma({g}, {_source(layer, i)}, m)"
        q = start + unit * (inputs + 1) + inputs
        yield f"m = mu * v{q}"
        yield f"w{q} = (w{q} + m) + {g}"
        yield f"v{q} = m + {g}"


def _source(layer: int, i: int) -> str:
    return f"x{i}" if layer == 0 else f"o{layer - 1}_{i}"

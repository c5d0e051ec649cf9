#!/usr/bin/env python3
"""Type stubs of the module from its docstrings, which pybind11 begins with signatures: make_stubs.py FILE.pyi

Every class, method, property and function of the module is in them, so they cannot be out of date.
"""

import inspect
import keyword
import pathlib
import re
import sys

import plumbline._plumbline as module

HEADER = '''"""Made by python/src/make_stubs.py from the module's docstrings."""

from __future__ import annotations

import os
from typing import Any, Callable, Dict, List, Optional, Union

import numpy

__version__: str
'''
SIGNATURE = re.compile(r"^(?:\d+\. )?(?P<name>\w*)\((?P<arguments>.*)\) -> (?P<result>.+)$")
# What pybind11 calls an object, by the argument's name; the docstrings tell the rest.
OBJECTS = {"time": "Optional[float]", "time_ns": "Optional[int]", "color": "Optional[numpy.ndarray]", "imu": "Optional[numpy.ndarray]",
           "initial_pose": "Optional[numpy.ndarray]", "orientation_covariance": "Optional[numpy.ndarray]", "vertices": "numpy.ndarray",
           "triangles": "numpy.ndarray", "normals": "Optional[numpy.ndarray]", "colors": "Optional[numpy.ndarray]",
           "camera": "Optional[Camera]", "intrinsics": "Optional[Camera]", "output": "Union[str, os.PathLike, None]",
           "on_frame": "Optional[Callable[[FrameReport], Any]]", "log": "Optional[Callable[[str, str], Any]]",
           "sequence": "Union[Sequence, str, os.PathLike]", "reference": "Union[Trajectory, str, os.PathLike]",
           "estimate": "Union[Trajectory, str, os.PathLike]"}
OVERLOADED = re.compile(r"^\w+\(\*args, \*\*kwargs\)|^Overloaded function\.$")


def type_of(text: str) -> str:
    """A type as a stub has it."""
    text = re.sub(r"\bplumbline::\w+(::\w+)*\b", "Any", text)
    text = re.sub(r"(plumbline\.)?_plumbline\.", "", text)
    text = re.sub(r"numpy\.ndarray\[[^\]]*\]|numpy\.ndarray", "numpy.ndarray", text)
    text = text.replace("os.PathLike", "Union[str, os.PathLike]").replace("Union[Union[str, os.PathLike], str, bytes]", "Union[str, os.PathLike]")
    return re.sub(r"\b(object|handle)\b", "Any", text)


def split(arguments: str):
    """At the commas that are in no bracket and no string."""
    parts, depth, quote, begin = [], 0, "", 0
    for at, c in enumerate(arguments):
        if quote:
            quote = "" if c == quote else quote
        elif c in "'\"":
            quote = c
        elif c in "([{<":
            depth += 1
        elif c in ")]}>" and arguments[at - 1] != "-":
            depth -= 1
        elif c == "," and depth == 0:
            parts.append(arguments[begin:at].strip())
            begin = at + 1
    return parts + [arguments[begin:].strip()] if arguments.strip() else []


def argument(text: str) -> str:
    if text in ("*", "/", "*args", "**kwargs"):
        return text
    name, _, rest = text.partition(": ")
    if name == "self" or not rest:
        return name
    kind, _, default = rest.partition(" = ")
    kind = type_of(kind)
    return f"{name}: {OBJECTS.get(name, kind) if kind == 'Any' else kind}" + (" = ..." if default else "")


def signatures(doc: str):
    return [match for line in (doc or "").splitlines() if (match := SIGNATURE.match(line.strip()))
            and match["arguments"] != "*args, **kwargs"]


def body(doc: str) -> list:
    """The docstring without its signatures."""
    lines = [line for line in (doc or "").splitlines() if not SIGNATURE.match(line.strip()) and not OVERLOADED.match(line.strip())]
    return re.sub(r"\n\n+", "\n\n", "\n".join(lines).strip()).splitlines()


def docstring(doc: str, indent: str):
    lines = body(doc)
    if not lines:
        return [f"{indent}..."]
    text = "\n".join([lines[0]] + [indent + line.strip() if line.strip() else "" for line in lines[1:]])
    return [f'{indent}"""' + text.replace("\\", "\\\\") + '"""', f"{indent}..."]


def function(name: str, thing, indent: str, decorator: str = ""):
    found = signatures(thing.__doc__)
    for match in found:
        if len(found) > 1:
            yield f"{indent}@overload"
        if decorator:
            yield f"{indent}@{decorator}"
        given = [argument(part) for part in split(match["arguments"])]
        yield f"{indent}def {name}({', '.join(given)}) -> {type_of(match['result'])}:"
        yield from docstring(thing.__doc__, indent + "    ")


def members(kind, indent: str = "    "):
    for name, thing in vars(kind).items():
        if keyword.iskeyword(name):
            continue
        if isinstance(thing, property):
            result = signatures(thing.fget.__doc__)
            of = type_of(result[0]["result"]) if result else "Any"
            yield f"{indent}@property"
            yield f"{indent}def {name}(self) -> {of}:"
            yield from docstring(thing.__doc__, indent + "    ")
            if thing.fset is not None:
                yield f"{indent}@{name}.setter"
                yield f"{indent}def {name}(self, value: Any) -> None: ..."
        elif isinstance(thing, staticmethod):
            yield from function(name, thing.__func__, indent, "staticmethod")
        elif name == "__init__" or (not name.startswith("_") or name in ("__len__", "__getitem__", "__iter__", "__next__", "__eq__")):
            if callable(thing):
                yield from function(name, thing, indent)


def stubs():
    for name, thing in vars(module).items():
        if inspect.isclass(thing):
            base = "(RuntimeError)" if issubclass(thing, Exception) else ""
            yield f"\nclass {name}{base}:"
            yield from docstring(thing.__doc__, "    ")[:-1] or ["    ..."]
            yield from members(thing)
            yield "    ..."
        elif callable(thing) and not name.startswith("_"):
            yield ""
            yield from function(name, thing, "")


def main() -> int:
    text = HEADER + "\n".join(stubs()) + "\n"
    if "@overload" in text:
        text = text.replace("Union\n", "Union, overload\n", 1)
    compile(text, sys.argv[1], "exec")  # a stub that is no Python must not be installed
    pathlib.Path(sys.argv[1]).write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

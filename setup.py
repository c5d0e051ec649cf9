"""The wheel of the Python module, built by scikit-build from python/CMakeLists.txt."""

import pathlib
import re

from skbuild import setup

HERE = pathlib.Path(__file__).parent
VERSION = re.search(r"project\(plumbline VERSION ([\d.]+)", (HERE / "CMakeLists.txt").read_text(encoding="utf-8"))[1]

setup(
    name="plumbline",
    version=VERSION,
    description="Dense 3D reconstruction from depth and orientation",
    long_description=(HERE / "docs" / "library.md").read_text(encoding="utf-8"),
    long_description_content_type="text/markdown",
    license="Apache-2.0",
    python_requires=">=3.9",
    install_requires=["numpy"],
    packages=["plumbline"],
    package_dir={"": "python"},
    package_data={"plumbline": ["py.typed", "*.pyi"]},
    cmake_source_dir="python",
    cmake_args=["-G", "Ninja"],
)

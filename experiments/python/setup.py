"""Builds the module by CMake, like the rest of raylex, and packs it. RAYLEX_BUILD names a build folder, so that an
existing build is used; by default setuptools' own folder."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        build = pathlib.Path(os.environ.get("RAYLEX_BUILD") or self.build_temp).resolve()
        if shutil.which("cmake") is None:
            raise SystemExit("cmake is not installed; expected the packages of experiments/packages.txt")
        configure = ["cmake", "-S", ROOT, "-B", build, "-DCMAKE_BUILD_TYPE=Release", "-DRAYLEX_PYTHON=ON",
                     f"-DPython3_EXECUTABLE={sys.executable}", "-DRAYLEX_UNITY_BATCH=40", "-DRAYLEX_TESTS=OFF"]
        if (build / "CMakeCache.txt").exists():
            configure = ["cmake", build]  # the user's folder: its settings stay
        elif shutil.which("ninja"):
            configure += ["-G", "Ninja"]
        subprocess.run(configure, check=True)
        subprocess.run(["cmake", "--build", build, "--target", "raylex_python", "planted_error", "--parallel",
                        str(os.cpu_count() or 1)], check=True)
        made = list((build / "python" / "raylex").glob("_raylex.*.so"))
        if len(made) != 1:
            raise SystemExit("CMake did not build the module; expected python3-dev and pybind11-dev to be installed")
        target = pathlib.Path(self.get_ext_fullpath(extension.name))
        (target.parent / "plugins").mkdir(parents=True, exist_ok=True)
        shutil.copy2(made[0], target)
        shutil.copy2(build / "plugins" / "libplanted_error.so", target.parent / "plugins")


version = re.search(r"project\(raylex VERSION ([0-9.]+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
setup(version=version, packages=["raylex"], package_data={"raylex": ["*.pyi", "py.typed"]},
      ext_modules=[Extension("raylex._raylex", [])], cmdclass={"build_ext": CMakeBuild})

"""The installed package: its types match the declarations; installation by `cmake --install`, and by pip, offline, in a
venv (only with --full)."""

import ast
import os
import pathlib
import subprocess
import sys
import unittest

import raylex
from support import FULL, ROOT, Case

BUILD = pathlib.Path(os.environ.get("RAYLEX_BUILD", ROOT / "build" / "release"))
TRY = "import raylex, sys; print(raylex.__file__); sys.exit(bool(raylex.lpe.check({'a': 'CL'})))"


def clean_environment(**more):
    environment = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    return {**environment, **more}


class Declared(Case):
    def test_stubs_match_the_module(self):
        stub = ast.parse((ROOT / "experiments" / "python" / "raylex" / "_raylex.pyi").read_text())
        declared = {}
        for node in stub.body:
            if isinstance(node, (ast.ClassDef, ast.FunctionDef)):
                members = node.body if isinstance(node, ast.ClassDef) else []
                declared[node.name] = {each.name for each in members if isinstance(each, ast.FunctionDef)}
        module = raylex._raylex
        there = {name for name in vars(module) if callable(getattr(module, name)) and not name.startswith("__")}
        self.assertEqual(there, set(declared))
        for name, members in declared.items():
            kind = getattr(module, name)
            if not isinstance(kind, type):
                continue
            public = {each for each in vars(kind) if not each.startswith("_")}
            self.assertEqual(public, {each for each in members if not each.startswith("_")}, name)

    def test_everything_public_is_documented(self):
        for module in (raylex, raylex.lpe, raylex.experiment, raylex.plugins):
            self.assertTrue(module.__doc__)
            for name in getattr(module, "__all__", []):
                self.assertTrue(getattr(module, name).__doc__, f"{module.__name__}.{name}")


class Installed(Case):
    def test_cmake_installs_it(self):
        prefix = self.folder / "prefix"
        done = subprocess.run(["cmake", "--install", BUILD, "--prefix", prefix], capture_output=True, text=True,
                              check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        # It works where it is moved to.
        prefix = prefix.rename(self.folder / "moved")
        package, = prefix.glob("lib/python*/dist-packages/raylex/__init__.py")
        scene = prefix / "share" / "raylex" / "scenes" / "prism" / "scene.pbrt"
        for arguments in (["stability", "--list"], ["stability", "--list", "--plugin", "planted_error"],
                          ["render", scene, "--commands=make", "--shards", "2"]):
            done = subprocess.run([prefix / "bin" / "raylex", *arguments], capture_output=True, text=True, check=False,
                                  cwd=self.folder)
            self.assertEqual(done.returncode, 0, f"{arguments}: {done.stderr}")
        for name in ("man/man1/raylex-render.1", "bash-completion/completions/raylex", "raylex/scenes/prism/scene.pbrt",
                     "raylex/raylex.ocio", "doc/raylex/experiments/docs/tutorial.md"):
            self.assertTrue((prefix / "share" / name).is_file(), name)
        environment = clean_environment(PYTHONPATH=str(package.parents[1]))
        done = subprocess.run([sys.executable, "-c", TRY], capture_output=True, text=True, env=environment, check=False,
                              cwd=self.folder)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(done.stdout.strip(), str(package))

    def test_a_moved_build_folder_takes_its_links_along(self):
        for link in (BUILD / "stability", BUILD / "cluster", BUILD / "python" / "raylex" / "__init__.py"):
            self.assertFalse(os.path.isabs(os.readlink(link)), link)
            self.assertTrue(link.exists(), link)

    def test_cmake_does_not_overwrite_a_package(self):
        mark = self.folder / "share" / "doc" / "raylex" / "changelog.Debian.gz"
        mark.parent.mkdir(parents=True)
        mark.touch()
        done = subprocess.run(["cmake", "--install", BUILD, "--prefix", self.folder], capture_output=True, text=True,
                              check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("apt remove raylex", done.stderr)
        self.assertFalse((self.folder / "bin").exists())

    @unittest.skipUnless(FULL, "of --full")
    def test_pip_installs_it_offline(self):
        venv = self.folder / "venv"
        for command in ([sys.executable, "-m", "venv", "--system-site-packages", venv],
                        [venv / "bin" / "pip", "install", "--no-build-isolation", "--no-index",
                         ROOT / "experiments" / "python"],
                        [venv / "bin" / "python", "-c", TRY]):
            done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=self.folder,
                                  env=clean_environment(RAYLEX_BUILD=str(BUILD)))
            self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}\n{done.stderr}")
        self.assertIn("site-packages", done.stdout)


if __name__ == "__main__":
    unittest.main()

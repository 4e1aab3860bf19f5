"""The documents: links lead somewhere, named files exist, and facts agree with the program.

Needs neither the module nor NumPy, so it also runs by itself: python3 -m unittest tests/python/test_documents.py
"""

import os
import pathlib
import re
import subprocess
import tomllib
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
DOCS = ROOT / "experiments" / "docs"
PROGRAM = pathlib.Path(os.environ.get("RAYLEX_PROGRAM", ROOT / "build" / "release" / "raylex"))
FOLDERS = ("lpe", "display", "geoaovs", "transport", "experiments", "tests")
MOST_LINES = 250


def documents():
    found = [ROOT / "README.md"]
    for folder in FOLDERS:
        found += sorted((ROOT / folder).rglob("*.md"))
    return found


def without_code(text):
    """The text without blocks of code, fenced or indented."""
    text = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    return re.sub(r"^(?: {4}|\t).*$", "", text, flags=re.MULTILINE)


def anchors(text):
    """The anchors of a page's headings, as GitHub and the web site make them."""
    made = set()
    for heading in re.findall(r"^#+ (.*)$", without_code(text), re.MULTILINE):
        plain = re.sub(r"[^\w\- ]", "", re.sub(r"`", "", heading).strip().lower())
        made.add(plain.replace(" ", "-"))
    return made


class Pages(unittest.TestCase):
    def test_no_page_is_too_long(self):
        for page in documents():
            with self.subTest(page=page.relative_to(ROOT)):
                self.assertLessEqual(len(page.read_text().splitlines()), MOST_LINES)

    def test_links_lead_to_pages_and_headings(self):
        for page in documents():
            for target in re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text())):
                if re.match(r"[a-z]+:", target):
                    continue
                with self.subTest(page=str(page.relative_to(ROOT)), link=target):
                    name, _, anchor = target.partition("#")
                    file = (page.parent / name).resolve() if name else page
                    self.assertTrue(file.exists(), "no such file")
                    if anchor:
                        self.assertIn(anchor, anchors(file.read_text()), "no such heading")

    def test_the_start_page_lists_every_page(self):
        listed = {(DOCS / target).resolve() for target in re.findall(r"\]\(([^)#]+)", (DOCS / "index.md").read_text())}
        for folder in ("experiments/docs", "transport/docs", "lpe/docs", "display/docs"):
            folder = ROOT / folder
            readme = folder.parent / "README.md"
            by_readme = {(readme.parent / t).resolve() for t in re.findall(r"\]\(([^)#]+)", readme.read_text())}
            measured = {(DOCS / t).resolve() for t in re.findall(r"\]\(([^)#]+)", (DOCS / "measured.md").read_text())}
            for page in sorted(folder.rglob("*.md")):
                with self.subTest(page=str(page.relative_to(ROOT))):
                    known = listed | by_readme | measured | {DOCS / "index.md"}
                    self.assertIn(page, known, "no page leads there")

    def test_named_files_exist(self):
        pattern = r"`((?:" + "|".join(FOLDERS) + r")/[\w./-]+\.(?:h|cpp|cmake|py|sh|toml|js|md|ipynb|exr))`"
        for page in documents():
            for name in set(re.findall(pattern, page.read_text())):
                with self.subTest(page=str(page.relative_to(ROOT)), file=name):
                    self.assertTrue((ROOT / name).exists(), "no such file")


class WhereIs(unittest.TestCase):
    def test_every_entry_names_a_file(self):
        rows = [line for line in (DOCS / "where-is.md").read_text().splitlines() if line.startswith("| ")]
        entries = [row for row in rows if row != "| concept | file |"]
        self.assertGreaterEqual(len(entries), 30)
        for row in entries:
            files = re.findall(r"`([^`]*/[^`]*)`", row)
            with self.subTest(entry=row):
                self.assertTrue(files, "no file is named")
                for file in files:
                    self.assertTrue((ROOT / file).is_file(), file)


class HardCases(unittest.TestCase):
    def setUp(self):
        self.cases = {}
        for suite in sorted(ROOT.glob("*/**/stability/*.toml")):
            for case in tomllib.loads(suite.read_text())["case"]:
                self.cases[case["name"]] = case.get("rows", [])
        self.assertTrue(self.cases, "no suite of hard cases was found")
        text = (DOCS / "hard-cases.md").read_text()
        rows = [[cell.strip() for cell in line.split(" | ")] for line in text.splitlines() if line.startswith("| ")]
        self.rows = {int(row[0][2:]): row for row in rows if row[0][2:].isdigit()}
        self.scenes = {row[0][2:]: row for row in rows if re.fullmatch("[A-Z]", row[0][2:])}

    def test_the_list_has_every_row_that_a_case_cites(self):
        self.assertEqual(sorted(self.rows), list(range(1, 69)))
        self.assertEqual("".join(sorted(self.scenes)), "ABCDEFGHIJKLMNOPQRSTUVWX")
        for name, rows in self.cases.items():
            self.assertLessEqual(set(rows), set(self.rows), name)

    def test_the_named_tests_cover_their_row(self):
        for number, row in self.rows.items():
            names = re.findall(r"`([^`]+)`", row[4])
            with self.subTest(row=number):
                self.assertTrue(names)
                for name in names:
                    self.assertIn(number, self.cases.get(name, []), name)

    def test_the_named_tests_of_scenes_exist(self):
        for letter, row in self.scenes.items():
            for name in re.findall(r"`([^`]+)`", row[-1]):
                with self.subTest(scene=letter, test=name):
                    self.assertTrue(name in self.cases or (ROOT / name).is_file())


class Budgets(unittest.TestCase):
    def test_the_page_has_the_table_of_the_source(self):
        source = (ROOT / "lpe" / "input" / "budgets.cpp").read_text()
        units = {"": "", " * kilo": " K", " * mega": " M", " * giga": " G"}
        rows = re.findall(r'^    {"(\w+)", ([^,* ]+)( \* \w+)?,', source, re.MULTILINE)
        expected = {name: number.replace("'", ",") + units[unit] for name, number, unit in rows}
        page = (DOCS / "rendering" / "limits.md").read_text()
        listed = dict(re.findall(r"^\| `(\w+)` \| ([\d,]+(?: [KMG])?) \|", page, re.MULTILINE))
        self.assertEqual(listed, expected)


@unittest.skipUnless(PROGRAM.exists(), "the program is not built")
class Facts(unittest.TestCase):
    def test_defaults_of_integrators(self):
        listed = subprocess.run([PROGRAM, "plugins"], capture_output=True, text=True, check=True).stdout
        text = re.sub(r"\s+", " ", (ROOT / "transport" / "docs" / "integrators.md").read_text())
        threshold = re.search(r"float rrthreshold = ([\d.]+)", listed)[1]
        self.assertIn(f"The default threshold is {threshold};", text)
        choice = re.search(r"string lightsampler = (\w+)", listed)[1]
        self.assertIn(f"its default is `{choice}`", text)
        strategy = re.search(r"string strategy = (\w+)", listed)[1]
        self.assertIn(f"`{strategy}` (default)", text)

    def test_the_page_of_settings_is_what_the_program_prints(self):
        page = subprocess.run([PROGRAM, "help", "settings"], capture_output=True, text=True, check=True).stdout
        self.assertEqual((DOCS / "rendering" / "settings.md").read_text(), page,
                         "raylex help settings > experiments/docs/rendering/settings.md brings it up to date")


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env bash
# Builds the documents as a web site that works offline, with search, opened as files or from a server.
#
#   bash experiments/manual.sh [OUT]     OUT defaults to build/manual in the clone
#
# The site is OUT/site. Its menu follows the start page, experiments/docs/index.md: one entry for each of its sections,
# then all other pages. Exit codes: 0 built, 2 something is missing or a link is broken.
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(dirname "$here")
case "${1:-}" in
    -h | --help) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "manual.sh: unknown option '$1'; expected a folder for the site, or nothing" >&2; exit 2 ;;
esac
bash "$here/install_packages.sh" mkdocs mkdocs-material python3 || exit 2
out=${1:-$root/build/manual}
mkdir -p "$out"
out=$(cd "$out" && pwd)
for folder in pages site; do
    if [ -e "$out/$folder" ] && [ ! -f "$out/mkdocs.yml" ]; then
        echo "manual.sh: $out/$folder is there and was not made by this script; name another folder" >&2
        exit 2
    fi
done
rm -rf "$out/pages" "$out/site"

# mkdocs reads one folder: the pages and their pictures, at the paths that they have in the clone.
cd "$root"
find README.md lpe display geoaovs transport experiments tests -name build -prune -o \
    \( -name '*.md' -o -path '*/pictures/*' \) -type f -print0 |
    while IFS= read -r -d '' file; do
        mkdir -p "$out/pages/$(dirname "$file")"
        cp "$file" "$out/pages/$file"
    done

/usr/bin/python3 - "$out" <<'PYTHON'
import json, pathlib, re, sys

out = pathlib.Path(sys.argv[1])
pages = out / "pages"
start = pages / "experiments/docs/index.md"
taken, menu = {start, pages / "README.md"}, [{"Start": ["README.md", "experiments/docs/index.md"]}]
for section in start.read_text().split("\n## ")[1:]:
    links = dict.fromkeys((start.parent / link).resolve() for link in re.findall(r"\]\(([^)#]+\.md)", section))
    found = [page for page in links if page not in taken]
    taken.update(found)
    menu.append({section.split(":")[0].split("\n")[0]: [str(page.relative_to(pages)) for page in found]})
rest = sorted(page for page in pages.rglob("*.md") if page not in taken)
menu.append({"More": [str(page.relative_to(pages)) for page in rest]})
for page in pages.rglob("*.md"):  # a bar in code in a table: GitHub wants a backslash before it, mkdocs none
    lines = page.read_text().split("\n")
    unescape = lambda line: re.sub(r"`[^`]*`", lambda code: code[0].replace("\\|", "|"), line)
    page.write_text("\n".join(unescape(line) if line.startswith("|") else line for line in lines))
config = {
    "site_name": "raylex", "docs_dir": "pages", "site_dir": "site", "use_directory_urls": False, "nav": menu,
    "theme": {"name": "material", "font": False, "features": ["navigation.tabs", "navigation.top", "search.highlight"]},
    "plugins": ["search"], "extra_css": ["wide.css"],
    "markdown_extensions": ["tables", "fenced_code", "sane_lists", {"toc": {"permalink": True}}],
}
(pages / "wide.css").write_text(".md-grid { max-width: 90rem; }\n.md-typeset table:not([class]) th { min-width: 0; }\n")
(out / "mkdocs.yml").write_text(json.dumps(config, indent=1))  # every JSON text is YAML
PYTHON
mkdocs build --quiet --strict -f "$out/mkdocs.yml" || exit 2

# A page that is opened as a file may not fetch the index of the search, nor start its worker: both come in a script.
/usr/bin/python3 - "$out/site" <<'PYTHON'
import json, pathlib, re, sys

site = pathlib.Path(sys.argv[1])
worker = next((site / "assets/javascripts/workers").glob("search.*.js")).read_text()
index = (site / "search/search_index.json").read_text()
(site / "search/offline.js").write_text(
    f"var __search = {{index: Promise.resolve({index}),\n"
    f"worker: URL.createObjectURL(new Blob([{json.dumps(worker)}]))}};\n")
bundle = re.compile(r'<script src="([^"]*)assets/javascripts/bundle')
for page in site.rglob("*.html"):
    text = page.read_text()
    page.write_text(bundle.sub(r'<script src="\1search/offline.js"></script>\g<0>', text))
PYTHON
echo "The documents: $out/site/index.html"

#!/usr/bin/env python3
"""Counts the Rust sources of two commits and writes the comparison as a page of the book.

    python3 tools/tree_size.py BEFORE [AFTER] [--out docs/tree_size.md]

Lines are those of the files as they are, blank lines and comments among them. A file's module `tests` and
what is below a folder `tests`, `benches` or `examples` is test code. A public item is a `pub` one (not
`pub(crate)`) outside test code. A type's name is that of a struct, an enum, a trait, a union or an alias
outside test code; those that a macro makes are not seen.
"""

import argparse
import pathlib
import re
import statistics
import subprocess
import tomllib
from collections import Counter

ITEM = re.compile(r"^\s*pub (?:const |async |unsafe |extern \"C\" )*(?:fn|struct|enum|union|trait|const|static|type|mod|macro)\b")
TYPE = re.compile(r"^\s*(?:pub(?:\([a-z: ]+\))? )?(?:unsafe )?(?:struct|enum|union|trait|type) ([A-Z]\w*)")
TESTS = re.compile(r"^#\[cfg\(test\)\]\n(?:#!?\[.*\]\n)*mod \w+ \{", re.M)
PUBLIC = re.compile(r"^\s*pub (?:unsafe )?(?:struct|enum|union|trait|type) ([A-Z]\w*)")
ASSOCIATED = re.compile(r"^\s+type ")


def git(*words):
    """What git prints."""
    return subprocess.run(["git", *words], check=True, capture_output=True).stdout


def sources(commit):
    """Text of each Rust and Cargo.toml file of a commit, by path."""
    names = git("ls-tree", "-r", "-z", "--name-only", commit).decode().split("\0")
    wanted = [name for name in names if name.endswith((".rs", "Cargo.toml", "README.md"))]
    return {name: git("show", f"{commit}:{name}").decode() for name in wanted}


def is_test(path):
    """Whether a whole file is test code."""
    parts = pathlib.PurePath(path).parts
    in_folder = any(part in ("tests", "benches", "examples", "fuzz") for part in parts[:-1])
    return in_folder or parts[-1] in ("tests.rs", "build.rs") or parts[-1].endswith("_tests.rs")


def product(text):
    """The text before the module of tests."""
    found = TESTS.search(text)
    return text[: found.start()] if found else text


def crates(files):
    """Folder, name and number of direct dependencies of each crate."""
    found = {}
    for path, text in files.items():
        if path.endswith("Cargo.toml"):
            manifest = tomllib.loads(text)
            if "package" in manifest:
                found[str(pathlib.PurePath(path).parent)] = manifest
    return found


def owner(path, folders):
    """The innermost crate a file belongs to."""
    inside = [folder for folder in folders if path.startswith(f"{folder}/")]
    return max(inside, key=len, default=None)


def count(commit):
    """All numbers of a commit."""
    files = sources(commit)
    manifests = crates(files)
    rust = {path: text for path, text in files.items() if path.endswith(".rs")}
    lines = {path: text.count("\n") for path, text in rust.items()}
    largest = max(lines, key=lines.get)
    code, types, public, items = Counter(), Counter(), Counter(), 0
    for path, text in rust.items():
        if is_test(path):
            continue
        rows = product(text).splitlines()
        code[owner(path, manifests)] += len(rows)
        items += sum(bool(ITEM.match(row)) for row in rows)
        named = [TYPE.match(row) for row in rows if not ASSOCIATED.match(row)]
        types.update(match[1] for match in named if match)
        public.update(match[1] for match in map(PUBLIC.match, rows) if match)
    dependencies = {
        manifest["package"]["name"]: len(manifest.get("dependencies", {}))
        + sum(len(t.get("dependencies", {})) for t in manifest.get("target", {}).values())
        for manifest in manifests.values()
    }
    most = max(code, key=code.get)
    return {
        "commit": git("log", "-1", "--format=%h, %cs", commit).decode().strip(),
        "files": len(rust),
        "lines": sum(lines.values()),
        "product": sum(code.values()),
        "median": statistics.median(lines.values()),
        "largest": (lines[largest], largest),
        "over": sum(n > 400 for n in lines.values()),
        "crates": len(manifests),
        "largest crate": (code[most], manifests[most]["package"]["name"]),
        "binary": code.get("vehicle_bridge", 0),
        "items": items,
        "types": len(types),
        "repeated": sum(n > 1 for n in types.values()),
        "public": len(public),
        "repeated public": sum(n > 1 for n in public.values()),
        "readme": len(files["README.md"].encode()),
        "dependencies": dependencies,
        "code": {manifests[folder]["package"]["name"]: n for folder, n in code.items() if folder},
        "names": sorted(((n, name) for name, n in types.items() if n > 1), reverse=True),
    }


def page(before, after):
    """The page of the book."""
    def row(text, of):
        return f"| {text} | {of(before)} | {of(after)} |"

    def number(key):
        return lambda counts: f"{counts[key]:,.0f}"

    def place(key):
        return lambda counts: "{:,} (`{}`)".format(*counts[key])

    def share(counts):
        return f"{counts['repeated']} of {counts['types']}"

    def public_share(counts):
        return f"{counts['repeated public']} of {counts['public']}"

    rows = [
        row("commit", lambda counts: counts["commit"]),
        row("crates", number("crates")),
        row("Rust files", number("files")),
        row("lines", number("lines")),
        row("lines without test code", number("product")),
        row("median lines of a file", number("median")),
        row("largest file", place("largest")),
        row("files over 400 lines", number("over")),
        row("largest crate, lines without test code", place("largest crate")),
        row("crate of the program `lmpc`, likewise", number("binary")),
        row("public items", number("items")),
        row("type names defined more than once", share),
        row("names of public types defined more than once", public_share),
        row("bytes of README.md", number("readme")),
    ]
    names = sorted(set(before["dependencies"]) | set(after["dependencies"]))
    def shown(value):
        return "" if value is None else f"{value:,}"
    each = [
        "| `{}` | {} | {} | {} | {} |".format(
            name,
            shown(before["dependencies"].get(name)),
            shown(after["dependencies"].get(name)),
            shown(before["code"].get(name)),
            shown(after["code"].get(name)),
        )
        for name in names
    ]
    repeated = ", ".join(f"`{name}` ({n})" for n, name in after["names"])
    return "\n".join([
        "# Size of the source tree",
        "",
        "Written by `make tree-size`, which compares the tree before its division into small crates with the last",
        "commit. `tools/tree_size.py` says what counts as what.",
        "",
        "| | before | after |",
        "|---|---|---|",
        *rows,
        "",
        "Type names defined more than once, with how often: " + repeated + ".",
        "",
        "## Crates",
        "",
        "| crate | direct dependencies before | after | lines without test code before | after |",
        "|---|---|---|---|---|",
        *each,
        "",
    ])


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("before")
    parser.add_argument("after", nargs="?", default="HEAD")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    text = page(count(options.before), count(options.after))
    if options.out:
        options.out.write_text(text)
    else:
        print(text, end="")


if __name__ == "__main__":
    main()

#!/usr/bin/env python3
"""The pages of docs/ agree with the tree: code shown is code that is built, links lead somewhere.

A fenced block after the line `<!-- code: FILE -->` must be that file, or, after `<!-- code: FILE NAME -->`, the part of
it from the line that holds NAME to the next empty line. `test_pages.py --write` puts the code into the pages.
"""
import os
import re
import sys
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
MARK = re.compile(r"<!-- code: (\S+)(?: ([^\n]+?))? -->\n```(\w*)\n(.*?)```\n", re.S)
LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")


def read(name):
    with open(os.path.join(ROOT, name), encoding="utf-8") as file:
        return file.read()


def pages():
    """All Markdown files of the tree, build folders and output excepted."""
    for folder, folders, names in os.walk(ROOT):
        relative = os.path.relpath(folder, ROOT)
        folders[:] = [f for f in folders if not f.startswith((".", "build", "node_modules")) and (relative, f) != (".", "out")]
        for name in sorted(names):
            if name.endswith(".md"):
                yield os.path.normpath(os.path.join(relative, name))


def code(name, part):
    text = read(name)
    if not part:
        return text
    lines = text.split("\n")
    start = next((i for i, line in enumerate(lines) if part in line), None)
    if start is None:
        raise AssertionError(f"{name} has no line with '{part}'")
    end = next((i for i in range(start, len(lines)) if not lines[i]), len(lines))
    return "\n".join(lines[start:end]) + "\n"


def anchor(heading):
    """The name that forges give to a heading."""
    return re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")


class Pages(unittest.TestCase):
    def test_code_in_pages_is_the_code_that_is_built(self):
        blocks = 0
        for page in pages():
            for file, part, _, shown in MARK.findall(read(page)):
                blocks += 1
                with self.subTest(page=page, file=file):
                    self.assertEqual(shown, code(file, part))
        self.assertGreaterEqual(blocks, 3)

    def test_links_lead_to_files_and_headings_of_the_tree(self):
        for page in pages():
            text = re.sub(r"```.*?```", "", read(page), flags=re.S)
            for link in LINK.findall(text):
                if re.match(r"[a-z]+:", link):
                    continue
                name, _, heading = link.partition("#")
                target = os.path.normpath(os.path.join(os.path.dirname(page), name)) if name else page
                with self.subTest(page=page, link=link):
                    self.assertTrue(os.path.exists(os.path.join(ROOT, target)), f"{page}: {link} leads nowhere")
                    if heading:
                        self.assertIn(heading, {anchor(h) for h in re.findall(r"^#+ (.+)$", read(target), re.M)})


def write():
    for page in pages():
        text = read(page)
        new = MARK.sub(lambda m: f"<!-- code: {m[1]}{' ' + m[2] if m[2] else ''} -->\n```{m[3]}\n{code(m[1], m[2])}```\n", text)
        if new != text:
            with open(os.path.join(ROOT, page), "w", encoding="utf-8") as file:
                file.write(new)
            print(f"wrote {page}")


if __name__ == "__main__":
    if sys.argv[1:] == ["--write"]:
        write()
    else:
        unittest.main()

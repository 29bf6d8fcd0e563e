"""tools/share deals: each landing's share, all of it in eight, from the commit alone."""
import os
import shutil
import subprocess
import sys
import tempfile

SHARE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "tools", "share")
NAMES = [f"io/name_{i}" for i in range(100)]


class Tree:
    """A repository with nothing in it but the tool."""

    def __init__(self, folder):
        self.folder = folder
        self.when = 1_700_000_000
        os.makedirs(os.path.join(folder, "tools"))
        shutil.copy(SHARE, os.path.join(folder, "tools"))
        self.git("init", "-q")
        self.write(".ci/turn", "0\n")
        self.commit()

    def git(self, *words):
        env = {**os.environ, "GIT_COMMITTER_DATE": f"{self.when} +0000", "GIT_AUTHOR_DATE": f"{self.when} +0000"}
        subprocess.run(["git", "-c", "user.name=n", "-c", "user.email=e", *words], cwd=self.folder, check=True, env=env)

    def write(self, name, text):
        path = os.path.join(self.folder, name)
        os.makedirs(os.path.dirname(path), exist_ok=True)
        with open(path, "w", encoding="ascii") as file:
            file.write(text)

    def commit(self, after_s=60):
        self.when += after_s
        self.git("add", "-A")
        self.git("commit", "-q", "--allow-empty", "-m", "c")

    def share(self, *words, given="", ci=""):
        env = {**os.environ, "CI": ci}
        done = subprocess.run([os.path.join(self.folder, "tools", "share"), *words], input=given, capture_output=True, text=True,
                              env=env, check=True)
        return done.stdout.split()

    def land(self, n_commits=1):
        for _ in range(n_commits):
            self.commit()
        self.share("next")
        self.commit()


def test_eight_landings_have_everything_once_however_many_commits_they_are(tree):
    dealt = []
    for n_commits in (1, 8, 2, 16, 1, 7, 3, 8):
        tree.land(n_commits)
        dealt += tree.share("pick", "any", given="\n".join(NAMES))
    assert sorted(dealt) == sorted(NAMES)


def test_the_same_commit_has_the_same_share_and_full_has_all(tree):
    tree.land()
    first = tree.share("pick", "any", given="\n".join(NAMES))
    assert first == tree.share("pick", "any", given="\n".join(NAMES)) and 0 < len(first) < len(NAMES)
    assert tree.share("pick", "any", given="\n".join(NAMES), ci="full") == NAMES


def test_new_names_move_no_other(tree):
    before = tree.share("pick", "any", given="\n".join(NAMES))
    after = tree.share("pick", "any", given="\n".join(["a/new_one", *NAMES]))
    assert [name for name in after if name in NAMES] == before


def test_a_landing_that_writes_no_turn_has_another_all_the_same(tree):
    tree.land()
    turn = int(tree.share("turn")[0])
    tree.commit()
    assert int(tree.share("turn")[0]) == turn, "a commit of the same landing"
    tree.commit(after_s=24 * 3600)
    assert int(tree.share("turn")[0]) == (turn + 1) % 8


def test_what_changed_since_the_landing_before_is_told_and_has_its_turn(tree):
    tree.land()
    tree.write("src/io/old.c", "")
    tree.land()
    tree.write("src/io/new.c", "")
    tree.write("docs/new.md", "")
    tree.land()
    assert "src/io/new.c" in tree.share("changed") and "docs/new.md" in tree.share("changed")
    assert tree.share("changed", "src") == ["src/io/new.c"]
    assert set(NAMES[:9]) <= set(tree.share("pick", "any", *NAMES[:9], given="\n".join(NAMES)))


def main():
    failed = 0
    for name, test in list(globals().items()):
        if not name.startswith("test_"):
            continue
        with tempfile.TemporaryDirectory() as folder:
            try:
                test(Tree(folder))
                print(f"[       OK ] {name}")
            except Exception as error:
                failed += 1
                print(f"{error!r}\n[  FAILED  ] {name}")
    sys.exit(failed > 0)


if __name__ == "__main__":
    main()

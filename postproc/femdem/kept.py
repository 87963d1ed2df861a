"""What has been made is used again only when all that it was made from is the same.

    python3 -m femdem.kept MESH COMMAND ...    runs the command, which makes MESH, unless it was made by it from the same files

Beside a product lies PRODUCT.made_from: a fingerprint of the product and of each thing it was made from. The things a
command is made from are its words, the files among them and the Python modules that a script among them takes from its
own folder. Files that the command itself writes (reports, figures) count as they were when it was done: without them it is
run again. What differs is said.
"""

import ast
import hashlib
import json
import subprocess
import sys
from pathlib import Path

from femdem.places import PACKAGES, environment

SUFFIX = ".made_from"
ITSELF = "what was made"
PACKAGE = "femdem"


def fingerprint(path):
    """SHA-256 of a file; of one that is not there, nothing."""
    try:
        with Path(path).open("rb") as file:
            whole = hashlib.sha256()
            while block := file.read(1 << 20):
                whole.update(block)
            return whole.hexdigest()
    except OSError:
        return ""


def text_fingerprint(text):
    """SHA-256 of a text."""
    return hashlib.sha256(text.encode()).hexdigest()


def with_modules(script):
    """A script and the modules it imports from its own folder or from this package, they too with what they import."""
    found, waiting = [], [Path(script)]
    while waiting:
        path = waiting.pop()
        if path in found:
            continue
        found.append(path)
        try:
            tree = ast.parse(path.read_text(encoding="utf-8"))
        except (OSError, SyntaxError, UnicodeDecodeError):
            continue
        names = []
        for node in ast.walk(tree):
            if isinstance(node, ast.Import):
                names += [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names += [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        # Of the folder that holds this package only the package counts: beside an installed one lie all others
        own = [name for name in names if name.partition(".")[0] == PACKAGE]
        places = [(path.parent, name) for name in names] + [(PACKAGES, name) for name in own]
        waiting += [file for folder, name in places if (file := module_file(name, folder))]
    return found


def module_file(name, folder):
    """File of a module with a dotted name, below a folder; none when it is elsewhere."""
    path = Path(folder, *name.split("."))
    files = path.with_name(path.name + ".py"), path / "__init__.py"
    return next((file for file in files if file.is_file()), None)


def ingredients_of(command, folder="."):
    """Fingerprints of what a command, run in a folder, makes its product from, by name."""
    words = [str(word) for word in command]
    found = {"the command": " ".join(words)}
    for before, word in zip(["", *words], words, strict=False):
        path = Path(folder) / (word.partition("=")[2] or word)
        if before == "-m":
            path = module_file(word, PACKAGES) or path
        if path.is_file():
            for one in with_modules(path) if path.suffix == ".py" else [path]:
                name = one.name if one.name not in found else f"{one.parent.name}/{one.name}"
                found[name] = fingerprint(one)
    return found


class Kept:
    """A product and the record of what it was made from.

    proof: file whose fingerprint stands for the product, when that is a directory.
    """

    def __init__(self, product, proof=None):
        self.product = Path(product)
        self.proof = Path(proof or product)
        self.record = self.product.with_name(self.product.name + SUFFIX)

    def known(self):
        """What the product was made from, as recorded; None when nothing is recorded."""
        try:
            return json.loads(self.record.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return None

    def differs(self, ingredients):
        """Why the product cannot be used again, in words; empty when it can."""
        known = self.known()
        if not self.proof.is_file():
            return "it is not there"
        if not isinstance(known, dict):
            return "how it was made is not recorded"
        now = {**ingredients, ITSELF: fingerprint(self.proof)}
        other = [name for name in {**now, **known} if now.get(name) != known.get(name)]
        return f"{', '.join(other)} changed" if other else ""

    def forget(self):
        """From now on the product counts as not made: call it before making it anew."""
        self.record.unlink(missing_ok=True)

    def remember(self, ingredients):
        """Record what the product, which is there now, was made from."""
        now = {**ingredients, ITSELF: fingerprint(self.proof)}
        self.record.write_text(json.dumps(now, indent=1) + "\n", encoding="utf-8")


def make(product, command, folder=".", again=False):
    """Run a command in a folder unless its product there can be used again; the command's status. Says what it does."""
    kept = Kept(Path(folder) / product)
    why = "asked for" if again else kept.differs(ingredients_of(command, folder))
    if not why:
        print(f"{product}: kept, nothing it was made from has changed", flush=True)
        return 0
    print(f"{product}: made now ({why})", flush=True)
    kept.forget()
    before = fingerprint(kept.product)
    status = subprocess.run(
        [str(word) for word in command], cwd=folder, check=False, env=environment()
    ).returncode
    if status == 0 and not kept.product.is_file():
        print(f"error: {product} is not there after the command that should make it", file=sys.stderr)
        return 1
    if status == 0:
        kept.remember(ingredients_of(command, folder))
    elif before and fingerprint(kept.product) == before:
        print(f"{product} is still the old one: it does not belong to this input", file=sys.stderr)
    return status


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(make(sys.argv[1], sys.argv[2:]))

"""What a sweep does, on disk: a deck a run, the commands of the meshes, and plan.json, which the workflow and its jobs read.

    SWEEP/plan.json               runs, meshes, what to collect
    SWEEP/meshes/KEY/             a mesh; runs with the same mesh command share it
    SWEEP/runs/KEY/deck.nml       a run; its results and ended.json beside it
    SWEEP/table.csv               a row a run

Keys are made from what a mesh or a run is made from, so that rows added to a table leave what is done where it is.
"""

import hashlib
import json
import re
import shlex
import sys
from dataclasses import dataclass, field
from pathlib import Path

from femdem import deck_text
from femdem.kept import fingerprint, ingredients_of, text_fingerprint
from femdem.places import module
from femdem.results import ResultsError

MESH_LINE = re.compile(r"^ *! *mesh: *(.+)$", re.MULTILINE)
MESH_COMMANDS = {"femdem-mesh": "femdem.network.make_mesh", "femdem-traces": "femdem.network.make_traces"}
MESH = "mesh."  # what parameters of the mesh script start with
OUT = "--out"
KEY_LENGTH = 12


@dataclass
class Plan:
    """Everything the jobs need to know."""

    program: str
    runs: list  # {key, parameters, mesh: key or ""}
    meshes: dict  # key -> {commands, product}
    collect: dict
    made_from: dict = field(default_factory=dict)  # key of a mesh or run -> fingerprint

    def write(self, folder):
        """Write plan.json, when it differs from what is there"""
        write_if_new(Path(folder) / "plan.json", json.dumps(self.__dict__, indent=1) + "\n")

    @classmethod
    def read(cls, folder):
        """Read plan.json"""
        return cls(**json.loads((Path(folder) / "plan.json").read_text(encoding="utf-8")))


def write_if_new(path, text):
    """Write a file unless it holds this text already: what depends on it goes by its time"""
    if not path.is_file() or path.read_text(encoding="utf-8") != text:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")


def key_of(*parts):
    """A short name made from all parts"""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:KEY_LENGTH]


def mesh_commands(deck, source):
    """The commands of the deck's '! mesh:' lines, which run in a folder of their own: files beside the deck by their full paths"""
    found = []
    for line in MESH_LINE.findall(source):
        words = shlex.split(line)
        head, rest = words[0], words[1:]
        # Only what no command before it writes is a file beside the deck
        made = {word for command in found for word in command["words"]}
        rest = [
            str(deck.parent / word)
            if word not in made and (deck.parent / word).is_file() and not follows_out(rest, k)
            else word
            for k, word in enumerate(rest)
        ]
        if head in MESH_COMMANDS:
            start = module(MESH_COMMANDS[head])
        elif (deck.parent / head).is_file():
            start = [sys.executable, str((deck.parent / head).resolve())]
        else:
            raise ResultsError(
                f"{deck}: '! mesh: {head}': it is neither beside the deck nor {' or '.join(MESH_COMMANDS)}"
            )
        found.append({"name": head, "start": start, "words": rest})
    return found


def follows_out(words, k):
    """Is a word the value of --out?"""
    return k > 0 and words[k - 1] == OUT


def with_argument(commands, name, value):
    """The mesh commands with an argument changed: in the last that has it, else added to the last"""
    option = f"--{name.replace('_', '-')}"
    values = [str(one) for one in value] if isinstance(value, list) else shlex.split(str(value))
    commands = [{**one, "words": list(one["words"])} for one in commands]
    for one in reversed(commands):
        if option in one["words"]:
            place = one["words"].index(option) + 1
            end = place
            while end < len(one["words"]) and not one["words"][end].startswith("--"):
                end += 1
            one["words"][place:end] = values
            return commands
    commands[-1]["words"] += [option, *values]
    return commands


def settings(row, deck, source):
    """Deck text and mesh commands of one row"""
    commands = mesh_commands(deck, source)
    for name, value in row.items():
        if name.startswith(MESH):
            if not commands:
                raise ResultsError(
                    f"{name}: the deck has no line '! mesh: SCRIPT ...' whose argument this could be"
                )
            commands = with_argument(commands, name.removeprefix(MESH), value)
        elif value != "" and value is not None:
            source = deck_text.change(source, name, value)
    return source, commands


def make_plan(folder, deck, table, collect, program):
    """Decks and plan.json of a sweep; all that is wrong is said in one ResultsError"""
    folder, deck = Path(folder), Path(deck)
    if not deck.is_file():
        raise ResultsError(f"{deck}: there is no such file")
    source = deck.read_text(encoding="utf-8")
    plan = Plan(str(program), [], {}, collect)
    program_print = fingerprint(program)
    wrong, mesh_prints = [], {}
    for number, row in enumerate(table.rows, start=1):
        try:
            text, commands = settings(row, deck.resolve(), source)
        except ResultsError as error:
            wrong += [text for text in str(error).splitlines() if text not in wrong]
            continue
        mesh, product = "", deck_text.value_of(text, "run.mesh")
        if commands:
            words = [[*one["start"], *one["words"]] for one in commands]
            mesh = key_of([one["name"] for one in commands], [one["words"] for one in commands])
            if mesh not in mesh_prints:
                made_from = [ingredients_of(command, deck.parent) for command in words]
                mesh_prints[mesh] = text_fingerprint(json.dumps(made_from))
            plan.meshes[mesh] = {"commands": words, "product": product}
            plan.made_from[mesh] = mesh_prints[mesh]
            place = f"../../meshes/{mesh}/{product}"
        else:
            place = str((deck.parent / product).resolve())
        text = deck_text.change(text, "run.mesh", place)
        key = key_of(row)
        if key in plan.made_from:
            wrong.append(f"row {number} is the same as an earlier one")
            continue
        plan.runs.append({"key": key, "parameters": {name: row[name] for name in row}, "mesh": mesh})
        plan.made_from[key] = text_fingerprint(
            text + program_print + mesh_prints.get(mesh, fingerprint(place))
        )
        if not wrong:
            write_if_new(folder / "runs" / key / "deck.nml", text)
    if wrong:
        raise ResultsError("\n".join(wrong))
    plan.write(folder)
    return plan

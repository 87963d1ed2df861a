"""Change variables in the text of a deck, and leave everything else as it is.

    text = change(text, "joint[fractures].jrc0", 12)
    text = change(text, "boundary[top,shear].vx", 0.02)

A path is GROUP.VARIABLE. Where a deck has several groups of a name, [WORDS] choose those in which each word is the value of group,
stage or name. Of the groups that are chosen, those that have the variable are changed; when none has it, all get it.
"""

import itertools
import re
from dataclasses import dataclass

from femdem.results import ResultsError

PATH = re.compile(r"(?P<group>\w+)(\[(?P<words>[^\]]*)\])?\.(?P<variable>\w+)")
NAMING = ("group", "stage", "name")  # variables whose values choose a group


@dataclass
class Group:
    """A group of a deck in its text."""

    name: str
    values: dict  # variable -> (start, end) of its value in the text
    texts: dict  # variable -> value without quotes
    end: int  # place of the slash that ends it


def masked(text):
    """The text with comments and the inside of quotes made blank, of the same length"""
    out, quote, comment = [], "", False
    for letter in text:
        if letter == "\n":
            quote, comment = "", False
        elif comment:
            letter = " "
        elif quote:
            if letter == quote:
                quote = ""
            else:
                letter = " "
        elif letter in "'\"":
            quote = letter
        elif letter == "!":
            comment, letter = True, " "
        out.append(letter)
    return "".join(out)


def groups_of(text):
    """The groups of a deck in order"""
    plain = masked(text)
    found, place = [], 0
    while start := re.compile(r"&(\w+)").search(plain, place):
        end = plain.find("/", start.end())
        if end < 0:
            raise ResultsError(f"the group &{start[1]} is not closed: a '/' is missing")
        names = list(re.compile(r"(\w+)\s*=\s*").finditer(plain, start.end(), end))
        values = {}
        for one, following in itertools.zip_longest(names, names[1:]):
            stop = following.start() if following else end
            length = len(plain[one.end() : stop].rstrip(" \t\r\n,"))
            values[one[1].lower()] = (one.end(), one.end() + length)
        texts = {name: unquoted(text[a:b]) for name, (a, b) in values.items()}
        found.append(Group(start[1].lower(), values, texts, end))
        place = end + 1
    return found


def unquoted(text):
    """A value without its quotes"""
    return text[1:-1].replace(2 * text[0], text[0]) if text[:1] in ("'", '"') else text


def written(value):
    """A value as a deck has it: numbers and switches bare, all else in quotes"""
    if isinstance(value, bool):
        return ".true." if value else ".false."
    if isinstance(value, int | float):
        return repr(value)
    text = str(value).strip()
    if text.lower() in (".true.", ".false."):
        return text
    if text.lower() in ("true", "false"):
        return f".{text.lower()}."
    try:
        float(text.lower().replace("d", "e"))
    except ValueError:
        return "'" + text.replace("'", "''") + "'"
    return text


def chosen(groups, path):
    """Groups that a path means, and the variable"""
    match = PATH.fullmatch(path)
    if not match:
        raise ResultsError(f"{path}: it must be GROUP.VARIABLE or GROUP[NAME].VARIABLE")
    named = [group for group in groups if group.name == match["group"].lower()]
    if not named:
        there = ", ".join(dict.fromkeys(group.name for group in groups))
        raise ResultsError(f"{path}: the deck has no &{match['group']}; it has: {there}")
    words = [word.strip() for word in (match["words"] or "").split(",") if word.strip()]
    fit = [
        group for group in named if all(word in [group.texts.get(key) for key in NAMING] for word in words)
    ]
    if not fit:
        there = "; ".join(
            ", ".join(group.texts[key] for key in NAMING if key in group.texts) for group in named
        )
        raise ResultsError(f"{path}: no &{match['group']} has {', '.join(words)}; there are: {there}")
    return fit, match["variable"].lower()


def value_of(text, path):
    """Value of a variable in a deck, of the first group that has it; None when none has"""
    fit, variable = chosen(groups_of(text), path)
    return next((group.texts[variable] for group in fit if variable in group.texts), None)


def change(text, path, value):
    """The deck's text with a variable changed"""
    fit, variable = chosen(groups_of(text), path)
    have = [group for group in fit if variable in group.values]
    for group in reversed(have or fit):
        if have:
            start, end = group.values[variable]
            quoted = text[start:end][:1] in ("'", '"')
            new = "'" + str(value).replace("'", "''") + "'" if quoted else written(value)
        else:
            start = end = len(masked(text)[: group.end].rstrip(" \t\r\n,"))
            comma = "," if group.values else ""
            blank = "" if text[end : end + 1].isspace() else " "
            new = f"{comma} {variable} = {written(value)}{blank}"
        text = text[:start] + new + text[end:]
    return text

"""Many runs of one deck with other values, and one table of their results.

    femdem-sweep table.csv deck.nml --cores 2
    femdem-sweep sweep.yaml deck.nml --out sweep --collect 'k=permeability.kxx_m2 @ phase_2b'
    femdem-sweep sweep.yaml deck.nml --jobs 100 -- --executor slurm --default-resources slurm_account=rock runtime=10

A column of TABLE is a variable of the deck (joint.jrc0, boundary[top,shear].vx) or an argument of the script in the deck's
'! mesh:' line (mesh.size). Decks, meshes, results and table.csv go to the sweep's folder. Given again, the same command goes on
where it stopped; what is done is not done again, and what depends on changed values, scripts or another program is. A run that
fails does not stop the others: table.csv says how each ended. The engine is Snakemake; what follows -- is passed on to it.
"""

import argparse
import importlib.util
import os
import signal
import socket
import subprocess
import sys
import time
from pathlib import Path

from femdem.places import environment, program
from femdem.results import ResultsError
from femdem.sweep.collect import Specification
from femdem.sweep.job import DONE, ENDED, FAILED, FLAG, make_table, read_ended
from femdem.sweep.plan import make_plan
from femdem.sweep.table import read_table

BAD_INPUT, SOME_FAILED, INTERRUPTED = 2, 1, 130
WORKFLOW = Path(__file__).resolve().parent / "workflow.smk"
GUARD, LOG = "running", "snakemake.log"
LOOK_EVERY = 1.0  # seconds between two looks at what is done
SAY_EVERY = 10.0  # seconds between two lines of progress where the output is no terminal


def arguments_of(words=None):
    """The command line; the words after -- are Snakemake's"""
    words = list(sys.argv[1:] if words is None else words)
    place = words.index("--") if "--" in words else len(words)
    parser = argparse.ArgumentParser(
        prog="femdem-sweep", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("table", type=Path, help="table of parameters: .csv, .yaml")
    parser.add_argument("deck", type=Path, help="deck")
    parser.add_argument("--out", type=Path, help="folder of the sweep (default: the table's name beside it)")
    parser.add_argument(
        "--collect",
        action="append",
        default=[],
        metavar="[NAME=]WHAT",
        help="number to collect: TABLE.COLUMN [HOW] [@ STAGE or t=TIME] (repeat; default: the last row of the history)",
    )
    parser.add_argument(
        "--cores",
        type=int,
        default=os.cpu_count(),
        help="runs at a time on this machine (default: all cores)",
    )
    parser.add_argument("--jobs", type=int, help="jobs at a time on a cluster, with an executor after --")
    parser.add_argument(
        "--femdem", type=Path, default=program(), help="program (default: that of the project, or in PATH)"
    )
    parser.add_argument("--retry", action="store_true", help="do runs and meshes that failed again")
    parser.add_argument(
        "--plan", action="store_true", help="write decks and workflow, say what would be done, and stop"
    )
    arguments = parser.parse_args(words[:place])
    arguments.snakemake = words[place + 1 :]
    arguments.out = arguments.out or arguments.table.with_suffix("")
    return arguments


def collected(texts):
    """Names and specifications of --collect"""
    found = {}
    for text in texts:
        name, equals, rest = text.partition("=")
        # The = of t=TIME is none of a name
        named = equals and "@" not in name and "." not in name
        found[name.strip() if named else text] = rest.strip() if named else text
    return found


def check_names(plan, folder, femdem):
    """Ask the program about a deck of the sweep before hours go into meshes: does it know all names?"""
    deck = Path("runs") / plan.runs[0]["key"] / "deck.nml"
    done = subprocess.run([femdem, "--check", deck], cwd=folder, capture_output=True, text=True, check=False)
    # Values that are wrong in this run may be right in others: only what is wrong in all ends the sweep
    unknown = [
        line for line in done.stderr.splitlines() if line.startswith("error: ") and "there is no such" in line
    ]
    if unknown:
        raise ResultsError("\n".join(line.removeprefix("error: ") for line in unknown))


def is_alive(folder):
    """The process that works on this sweep now, if any: its number and machine"""
    try:
        machine, *numbers = (folder / GUARD).read_text(encoding="utf-8").split()
    except (OSError, ValueError):
        return ""
    if machine != socket.gethostname():
        return f"{numbers[0]} on {machine}"
    for number in numbers:
        if works(number):
            return f"{number} on {machine}"
    return ""


def works(process):
    """Is a process of this machine alive, and one of a sweep? (A number may have gone to another.)"""
    try:
        os.kill(int(process), 0)
        words = Path("/proc", process, "cmdline").read_bytes()
    except FileNotFoundError:
        return not Path("/proc/self").exists()  # without /proc: it is alive, that is all that is known
    except (OSError, ValueError):
        return False
    return b"snakemake" in words or b"sweep" in words


def forget_failures(plan, folder):
    """What failed counts as not done"""
    for kind, keys in (("runs", [run["key"] for run in plan.runs]), ("meshes", plan.meshes)):
        for key in keys:
            if read_ended(folder / kind / key, plan.made_from[key])["status"] == FAILED:
                for name in (ENDED, FLAG):
                    (folder / kind / key / name).unlink(missing_ok=True)


def snakemake(arguments, *more):
    """The command of Snakemake"""
    command = [sys.executable, "-m", "snakemake", "--snakefile", WORKFLOW, "--directory", arguments.out]
    command += ["--keep-going", "--rerun-incomplete", "--nolock", "--scheduler", "greedy"]
    command += ["--rerun-triggers", "mtime", "params", "input"]
    command += ["--jobs", arguments.jobs] if arguments.jobs else ["--cores", arguments.cores]
    return [str(word) for word in [*command, *arguments.snakemake, *more]]


def counts(plan, folder):
    """How many runs are done, and how many failed"""
    status = [
        read_ended(folder / "runs" / run["key"], plan.made_from[run["key"]])["status"] for run in plan.runs
    ]
    return status.count(DONE), status.count(FAILED)


def duration(seconds):
    """For people"""
    if seconds < 90:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400 else f"{seconds / 3600:.1f} h"


class Progress:
    """Says how far the sweep is and how long it will take."""

    def __init__(self, number, at_start):
        self.number, self.at_start = number, at_start
        self.start = self.said = time.monotonic()
        self.terminal = sys.stdout.isatty()

    def say(self, done, failed, last=False):
        """A line of progress: over the last one on a terminal, else now and then"""
        now = time.monotonic()
        if not (self.terminal or last or now - self.said >= SAY_EVERY):
            return
        self.said = now
        ended, new = done + failed, done + failed - self.at_start
        text = f"{ended} of {self.number} runs done" + (f", {failed} of them failed" if failed else "")
        text += f"; {duration(now - self.start)}"
        if new > 0 and ended < self.number:
            text += f", about {duration((now - self.start) / new * (self.number - ended))} left"
        print(
            f"\r{text:75s}" if self.terminal else text,
            end="\n" if last or not self.terminal else "",
            flush=True,
        )


def work(arguments, plan):
    """Let Snakemake do what is to be done; its exit status"""
    folder = arguments.out
    progress = Progress(len(plan.runs), sum(counts(plan, folder)))
    with (folder / LOG).open("w", encoding="utf-8") as log:
        engine = subprocess.Popen(
            snakemake(arguments),
            stdout=log,
            stderr=subprocess.STDOUT,
            env=environment(),
            start_new_session=True,
        )
        (folder / GUARD).write_text(f"{socket.gethostname()} {os.getpid()} {engine.pid}\n", encoding="utf-8")
        try:
            while engine.poll() is None:
                time.sleep(LOOK_EVERY)
                progress.say(*counts(plan, folder))
        except KeyboardInterrupt:
            os.killpg(engine.pid, signal.SIGTERM)
            engine.wait()
            print("\nstopped; the same command goes on from here")
            return INTERRUPTED
        finally:
            (folder / GUARD).unlink(missing_ok=True)
    progress.say(*counts(plan, folder), last=True)
    return engine.returncode


def main(words=None):
    arguments = arguments_of(words)
    try:
        table = read_table(arguments.table)
        collect = {**table.collect, **collected(arguments.collect)}
        for text in collect.values():
            Specification.parse(text)
        if not arguments.femdem.is_file():
            raise ResultsError(
                f"{arguments.femdem}: there is no such program; build it (./run.sh does), or name it with --femdem"
            )
        if importlib.util.find_spec("snakemake") is None:
            raise ResultsError(
                "Python has no module snakemake; the extra 'sweep' brings it: "
                "pip install './postproc[maps,sweep]' (manual/python.md)"
            )
        alive = is_alive(arguments.out)
        if alive:
            raise ResultsError(
                f"{arguments.out}: process {alive} works on this sweep; if it does not, remove {arguments.out / GUARD}"
            )
        plan = make_plan(arguments.out, arguments.deck, table, collect, arguments.femdem.resolve())
        check_names(plan, arguments.out, arguments.femdem.resolve())
    except (ResultsError, OSError) as error:
        for line in str(error).splitlines():
            print(f"error: {line}", file=sys.stderr)
        sys.exit(BAD_INPUT)
    if arguments.retry:
        forget_failures(plan, arguments.out)
    if arguments.plan:
        sys.exit(subprocess.run(snakemake(arguments, "--dry-run"), env=environment(), check=False).returncode)
    status = work(arguments, plan)
    print(make_table(plan, arguments.out))
    if status == INTERRUPTED:
        sys.exit(status)
    done, failed = counts(plan, arguments.out)
    if status != 0 or done + failed < len(plan.runs):
        print(
            f"error: {len(plan.runs) - done - failed} runs were not done; {arguments.out / LOG} tells why",
            file=sys.stderr,
        )
        sys.exit(SOME_FAILED)
    sys.exit(SOME_FAILED if failed else 0)

#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs clang-tidy, with the checks of .clang-tidy, on the .cpp files below some folders of the
repository and on the headers that they include. Exits with 1 on any finding.

Nine tenths of clang-tidy's time are spent on the headers of Eigen, MRPT and the standard library.
Therefore files of one folder are checked several at a time, as one source: several times
faster. Where such a source does not compile (two files define the same name), its files are
checked one at a time.
"""
import argparse
import concurrent.futures
import json
import os
import re
import shlex
import shutil
import subprocess
import sys

ROOT = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.path.join(ROOT, "build", "tidy")
GROUP_BYTES = 60000  # of source text in one group: keeps the slowest group below a minute
FINDING = re.compile(r"^(\S+):(\d+):(\d+): (warning|error): .*\[([\w.,-]+)\]$")


def configure():
    """Makes build/tidy/compile_commands.json. Nothing is built."""
    run = subprocess.run(["cmake", "--preset", "tidy"], cwd=ROOT, text=True,
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if run.returncode:
        sys.exit(run.stdout + "tidy.py: cmake --preset tidy failed")


def tracked(folders):
    names = subprocess.check_output(
        ["git", "ls-files", "-co", "--exclude-standard", "--", *folders], cwd=ROOT, text=True)
    return {os.path.join(ROOT, name) for name in names.split("\n") if name.endswith(".cpp")}


def compile_commands(files):
    """[(file, arguments, directory)] of the files that the build compiles, each once."""
    with open(os.path.join(BUILD, "compile_commands.json"), encoding="utf-8") as f:
        entries = json.load(f)
    found = {}
    for entry in entries:
        file = os.path.normpath(os.path.join(entry["directory"], entry["file"]))
        if file in files and file not in found:
            arguments = [a for a in shlex.split(entry["command"])[1:] if a not in ("-c",)]
            at = arguments.index("-o")
            del arguments[at:at + 2]
            arguments.remove(entry["file"])
            found[file] = (file, arguments, entry["directory"])
    return sorted(found.values())


def groups_of(commands):
    """Lists of files that have one folder and one set of arguments."""
    groups, size, last = [], 0, None
    for file, arguments, directory in commands:
        key = (os.path.dirname(file), arguments)
        size += os.path.getsize(file)
        if key != last or size > GROUP_BYTES:
            groups.append(([], arguments, directory))
            size, last = os.path.getsize(file), key
        groups[-1][0].append(file)
    return groups


def tidy(source, arguments, directory):
    run = subprocess.run(
        [PROGRAM, "--quiet", source, "--", *arguments], cwd=directory, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return run.returncode, run.stdout


def join(files):
    """Writes one source with the text of all files. Returns its name and, for each of its lines, the
    file and the line there. (Including the files would hide them from clang's static analyzer, which
    looks at functions of the main file only.)"""
    source = os.path.join(BUILD, "groups", os.path.relpath(files[0], ROOT).replace("/", "_"))
    origin = []
    with open(source, "w", encoding="utf-8") as out:
        for file in files:
            with open(file, encoding="utf-8") as f:
                lines = f.read().splitlines()
            origin += [f"{file}:{number}:" for number in range(1, len(lines) + 1)]
            out.writelines(line + "\n" for line in lines)
    return source, origin


def check(group):
    """(all well, text) of the files of a group."""
    files, arguments, directory = group
    if len(files) > 1:
        source, origin = join(files)
        code, text = tidy(source, arguments + ["-iquote", os.path.dirname(files[0])], directory)
        if "[clang-diagnostic-error]" not in text:
            where = re.compile("^" + re.escape(source) + r":(\d+):", re.MULTILINE)
            return code == 0, where.sub(lambda found: origin[int(found[1]) - 1], text)
    results = [tidy(file, arguments, directory) for file in files]
    return all(code == 0 for code, _ in results), "".join(text for _, text in results)


def print_new(text, seen):
    """Prints the findings of text, with their code, that no earlier text had."""
    show = False
    for line in text.splitlines():
        if FINDING.match(line):
            show = line not in seen
            seen.add(line)
        if show:
            print(line.replace(ROOT + "/", ""), flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("folders", nargs="*", default=["modules", "apps"],
                        help="folders or files to check (default: modules apps)")
    parser.add_argument("--each", action="store_true", help="check each file by itself")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    options = parser.parse_args()

    configure()
    commands = compile_commands(tracked(options.folders))
    if not commands:
        sys.exit(f"tidy.py: nothing is compiled below {' '.join(options.folders)}")
    groups = [([c[0]], *c[1:]) for c in commands] if options.each else groups_of(commands)
    # The longest first, so that none is left over at the end.
    groups.sort(key=lambda group: -sum(map(os.path.getsize, group[0])))

    shutil.rmtree(os.path.join(BUILD, "groups"), ignore_errors=True)
    os.makedirs(os.path.join(BUILD, "groups"))
    well, seen = True, set()
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        for good, text in pool.map(check, groups):
            well = well and good
            print_new(text, seen)
    print(f"clang-tidy: {len(seen)} findings in {len(commands)} files of {' '.join(options.folders)}")
    sys.exit(0 if well and not seen else 1)


PROGRAM = shutil.which("clang-tidy-14") or "clang-tidy"  # releases differ in what they find
if __name__ == "__main__":
    main()

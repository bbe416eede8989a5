#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
"""check_symbols.py PREFIX LIBRARY...: checks an install tree.

Prints each symbol that a library gives to the linker although no header below PREFIX/include declares
it with MRPT_FUSION_API. Prints a line too if more than 24 headers are installed. Exits with 1 if there
is any such line.
"""
import re
import subprocess
import sys
from pathlib import Path

MAX_HEADERS = 24
DECLARED_CLASS = re.compile(r"\b(?:class|struct)\s+MRPT_FUSION_API\s+(\w+)")
DECLARED_FUNCTION = re.compile(r"(?<!class )(?<!struct )\bMRPT_FUSION_API\b([^(;{]*)\(")
# The symbol table and what the linker itself adds.
LINKER = {"_init", "_fini", "_edata", "_end", "__bss_start"}


def declared_names(headers):
    names = set()
    for header in headers:
        text = header.read_text(encoding="utf-8")
        names |= set(DECLARED_CLASS.findall(text))
        names |= {words[-1] for words in
                  (re.findall(r"\w+", m) for m in DECLARED_FUNCTION.findall(text)) if words}
    return names


def identifiers(symbol):
    """The names in a symbol's own qualified name, without those of its parameters."""
    name = re.sub(r"\[abi:\w+\]", "", symbol)
    name = re.sub(r"^(?:vtable|typeinfo(?: name)?|VTT|guard variable|(?:non-)?virtual thunk)"
                  r" (?:for|to) ", "", name)
    return set(re.findall(r"[A-Za-z_]\w*", name.split("(")[0]))


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    prefix, libraries = Path(sys.argv[1]), sys.argv[2:]
    headers = sorted((prefix / "include").rglob("*.h"))
    names = declared_names(headers)
    faults = []
    if not headers:
        faults.append(f"{prefix}: has no headers")
    if len(headers) > MAX_HEADERS:
        faults.append(f"{prefix}: {len(headers)} headers are installed, more than {MAX_HEADERS}")
    for library in libraries:
        listed = subprocess.run(["nm", "-DC", "--defined-only", library], check=True,
                                capture_output=True, text=True).stdout
        count = 0
        for line in listed.splitlines():
            symbol = re.sub(r"^[0-9a-f]* +\w ", "", line)
            if symbol in LINKER:
                continue
            count += 1
            if not identifiers(symbol) & names:
                faults.append(f"{Path(library).name}: exports {symbol}, which no header declares")
        if count == 0:
            faults.append(f"{library}: exports nothing")
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())

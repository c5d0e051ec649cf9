#!/usr/bin/env python3
"""A manual page and bash's completion from the program's own help: from_help.py PROGRAM MAN.gz BASH"""

import gzip
import pathlib
import re
import subprocess
import sys

OPTION = re.compile(r"^  (-{1,2}[\w-]+(?:,-{1,2}[\w-]+)*)(.*)$")


def run(program, *words):
    return subprocess.run([program, *words], capture_output=True, text=True, check=True).stdout


def commands(text: str):
    """(name, description) of the subcommands that a help lists."""
    found, within = [], False
    for line in text.splitlines():
        if re.match(r"^Subcommands:|^Commands:", line):
            within = True
        elif within and (match := re.match(r"^  ([a-z][\w-]*)\s+(\S.*)$", line)):
            found.append((match[1], match[2]))
        elif within and found and re.match(r"^ {10,}\S", line):
            found[-1] = (found[-1][0], f"{found[-1][1]} {line.strip()}")
        elif within and not line.strip() and found:
            break
    return found


def options(text: str):
    return [name for line in text.splitlines() if (match := OPTION.match(line)) for name in match[1].split(",")]


def escaped(text: str) -> str:
    text = text.replace("\\", "\\e").replace("-", "\\-")
    return re.sub(r"^([.'])", r"\\&\1", text, flags=re.M)


def page(name: str, summary: str, version: str, parts) -> str:
    lines = [f'.TH {name.upper()} 1 "" "Plumbline {version}" "User commands"', ".SH NAME", f"{name} \\- {escaped(summary)}", ".SH SYNOPSIS",
             f".B {name}", r"[\fIoptions\fR] \fIcommand\fR [\fIarguments\fR]", ".SH DESCRIPTION",
             "Depth images in, camera trajectory and mesh out. Every command, with what its own help says:"]
    for command, text in parts:
        lines += [f".SS {name} {command}".rstrip(), ".nf", escaped(text.strip()), ".fi"]
    lines += [".SH EXIT STATUS", "0 where all went well, 1 for an error, 2 for a mistake in the command line, 128 and the signal's number where one "
              "ended it.", ".SH EXAMPLES", ".nf", escaped(f"{name} demo\n{name} run RECORDING \\-o out\n{name} view out".replace("\\-", "-")), ".fi"]
    return "\n".join(lines) + "\n"


def completion(name: str, first: list, per_command: dict) -> str:
    cases = "\n".join(f"    {command}) words=\"{' '.join(words)}\" ;;" for command, words in per_command.items())
    return f"""# bash completion of {name}, made by packaging/from_help.py from the program's help.
_{name}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} words
  if ((COMP_CWORD == 1)); then
    mapfile -t COMPREPLY < <(compgen -W "{' '.join(first)}" -- "$word")
    return
  fi
  case ${{COMP_WORDS[1]}} in
{cases}
    *) return ;;
  esac
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
  [[ $word == -* || ${{#COMPREPLY[@]}} -gt 0 && $word ]] || mapfile -t -O "${{#COMPREPLY[@]}}" COMPREPLY < <(compgen -f -- "$word")
}}
complete -o filenames -F _{name} {name}
"""


def helps_of(program: str, *before: str):
    """(words, help) of every command and its own commands."""
    for command, _ in commands(run(program, *before, "--help")):
        words = (*before, command)
        yield words, run(program, *words, "--help")
        yield from helps_of(program, *words)


def main() -> int:
    program, man, bash = sys.argv[1:4]
    text, version = run(program, "--help"), run(program, "--version").split()[-1]
    name = pathlib.Path(program).name
    helps = dict(helps_of(program))
    if not helps:
        sys.exit(f"{program} --help lists no commands")
    words = {}  # of each command: its own commands and all options
    for command, help_text in helps.items():
        words.setdefault(command[0], []).extend([*command[1:], *options(help_text)])
    summary = "dense 3D reconstruction from a depth camera and an orientation sensor"
    manual = page(name, summary, version, [("", text), *((" ".join(command), help_text) for command, help_text in helps.items())])
    pathlib.Path(man).write_bytes(gzip.compress(manual.encode(), 9, mtime=0))
    unique = {command: list(dict.fromkeys(of)) for command, of in words.items()}
    pathlib.Path(bash).write_text(completion(name, [*unique, *options(text)], unique), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())

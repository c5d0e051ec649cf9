#!/usr/bin/env python3
"""Runs what README.md tells its reader to type: run_readme.py ROOT PLUMBLINE [EXAMPLE].

The `sh` blocks' commands of the program run in a folder where every sequence that they name is a small simulated one. Of those
that need a device, the net or many minutes, and of all others too, the options are looked up in the command's own help;
`./dev` commands must be among those that ./dev lists. EXAMPLE is the program that the `cpp` block makes.
Exits with 1 and one line a finding.
"""

import pathlib
import re
import shlex
import subprocess
import sys
import tempfile

DEVICE = re.compile(r"\bserial:|\bi2c:|\bopenni2\b|\bfreenect\b|\blive:")
ELSEWHERE = {"download": "the net", "batch": "minutes", "reproduce": "minutes", "calibrate": "a long recording", "record": "a device"}
SEQUENCE = re.compile(r"^(SEQUENCE|RECORDING|rgbd_dataset\w+)$")


def blocks(readme: str, language: str):
    return re.findall(rf"^```{language}\n(.*?)^```", readme, re.M | re.S)


def commands(readme: str):
    for block in blocks(readme, "sh"):
        for line in block.replace("\\\n", " ").splitlines():
            words = shlex.split(line, comments=True)
            if words:
                yield line.strip(), words


def unknown_options(program: str, words: list[str]):
    text = subprocess.run([program, words[0], "--help"], capture_output=True, text=True, check=False).stdout
    if not text:
        return [f"there is no command {words[0]}"]
    return [f"{words[0]} has no option {word}" for word in words[1:] if word.startswith("-") and not re.search(rf"(?<![\w-]){word}(?![\w-])", text)]


def main() -> int:
    root, program = pathlib.Path(sys.argv[1]), sys.argv[2]
    readme = (root / "README.md").read_text(encoding="utf-8")
    bad, listed = [], subprocess.run([root / "dev", "help"], capture_output=True, text=True, check=True).stdout
    with tempfile.TemporaryDirectory(prefix="plumbline_readme_") as folder:
        here = pathlib.Path(folder)
        start = lambda words: subprocess.run(words, cwd=here, capture_output=True, text=True, check=False, timeout=300)
        made = start([program, "simulate", "-o", "simulated", "--frames", "12", "--size", "160x120"])
        if made.returncode:
            sys.exit(f"simulate: {made.stderr}")
        (here / "orientation.txt").symlink_to(here / "simulated" / "orientation.txt")
        not_made = set()  # files that commands would have made that did not run
        for line, words in commands(readme):
            if words[0] == "./dev":
                bad += [] if re.search(rf"^  {words[1]}\b", listed, re.M) else [f"{line}: ./dev has no such command"]
                continue
            if pathlib.Path(words[0]).name != "plumbline":
                print(f"not run: {line}")
                continue
            words = words[1:]
            bad += [f"{line}: {message}" for message in unknown_options(program, words)]
            if DEVICE.search(line) or words[0] in ELSEWHERE:
                print(f"not run, as it needs {ELSEWHERE.get(words[0], 'a device')}: {line}")
                not_made |= {word for option, word in zip(words, words[1:]) if option in ("-o", "--output", "--depth-output")}
                continue
            if needed := [word for word in words if word in not_made and not SEQUENCE.match(word)]:
                print(f"not run, as nothing has made {needed[0]}: {line}")
                continue
            for word in words:
                name = word.split("/")[0]
                if SEQUENCE.match(name) and not (here / name).exists():
                    (here / name).symlink_to(here / "simulated")
            done = start([program, *words, *(["--no-open"] if words[0] == "view" else [])])
            print(f"{'ran' if done.returncode == 0 else 'FAILED'}: {line}")
            if done.returncode:
                bad.append(f"{line}: exit {done.returncode}: {done.stderr.strip()}")
        if len(sys.argv) < 4:
            bad.append("README.md has no C++ example")
        else:
            done = start([sys.argv[3], "simulated"])
            print("C++ example:", done.stdout.strip() or "says nothing")
            if done.returncode:
                bad.append(f"the C++ example: exit {done.returncode}: {done.stdout} {done.stderr}")
    print("\n".join(bad + [f"{len(bad)} findings"]))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())

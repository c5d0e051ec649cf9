#!/usr/bin/env python3
"""Fails if a stage takes clearly more instructions than counts.json says.

Callgrind counts them on one thread and with a fixed instruction set, so that the figures repeat on every machine that
has it. A stage that has become faster is told, too: then write the new counts with --update and commit them.

usage: check_counts.py VALGRIND BENCH_COUNTS COUNTS_JSON [--update]
exit code: 0, 1 for a regression, 77 (skipped) if this processor lacks the instruction set
"""
import json
import pathlib
import re
import subprocess
import sys
import tempfile

TOLERANCE = 0.10
SKIPPED = 77


def count(valgrind: str, program: str, instruction_set: str) -> dict:
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [valgrind, "--tool=callgrind", "--instr-atstart=no", f"--callgrind-out-file={folder}/counts", program, instruction_set],
            capture_output=True, text=True)
        if "does not have the instruction set" in run.stderr:
            print(f"skipped: this processor lacks {instruction_set}")
            sys.exit(SKIPPED)
        if run.returncode:
            sys.exit(run.stderr)
        counts = {}
        for path in sorted(pathlib.Path(folder).glob("counts.*"), key=lambda p: int(p.suffix[1:])):
            text = path.read_text(errors="replace")
            stage = re.search(r"^desc: Trigger: Client Request: (.*)$", text, re.M)
            total = re.search(r"^totals: (\d+)$", text, re.M)
            if stage and total:
                counts[re.sub(r"\s+", " ", stage[1])] = int(total[1])
        return counts


def main() -> int:
    valgrind, program, path = sys.argv[1:4]
    known = json.loads(pathlib.Path(path).read_text())
    counts = count(valgrind, program, known["instruction_set"])
    if not counts:
        sys.exit("callgrind counted nothing")
    if "--update" in sys.argv:
        pathlib.Path(path).write_text(json.dumps({"instruction_set": known["instruction_set"], "counts": counts}, indent=2) + "\n")
    expected = known["counts"]
    bad = 0
    for stage in sorted(expected.keys() | counts.keys()):
        now, before = counts.get(stage), expected.get(stage)
        if now is None or before is None:
            verdict = "not measured" if now is None else "not in counts.json"
            bad += 1
        else:
            change = now / before - 1
            verdict = f"{change:+.1%}"
            if change > TOLERANCE:
                verdict += "  MORE"
                bad += 1
            elif change < -TOLERANCE:
                verdict += "  fewer: run with --update"
        print(f"{stage:<45}{before or 0:>14,}{now or 0:>14,}  {verdict}")
    return 1 if bad and "--update" not in sys.argv else 0


if __name__ == "__main__":
    sys.exit(main())

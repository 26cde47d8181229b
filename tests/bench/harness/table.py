"""Prints results, as text and as the Markdown table of docs/performance.md."""
import os
import subprocess

from .cases import CASES, ROOT
from .measure import FIGURES

PEERS = {"povray": "POV-Ray 3.7", "cycles": "Cycles"}
BEGIN, END = "<!-- tools/bench --write: from here", "<!-- to here -->"
PAGE = os.path.join(ROOT, "docs/performance.md")


def number(value, figure):
    digits = FIGURES[figure][2]
    if digits == 9:
        return f"{value:.2e}"
    return f"{value:,.{digits}f}"


def verdict(case, figure, row):
    """(aim, reached) as text."""
    for aim in case.aims:
        if aim.figure != figure:
            continue
        unit = FIGURES[figure][1].split(" ")[0]
        if aim.absolute:
            more = FIGURES[figure][3]
            good = row["ours"] >= aim.least if more else row["ours"] <= aim.least
            return f"{'at least' if more else 'at most'} {aim.least:g} {unit}", good
        if "ratio" not in row:
            return f"{aim.least:g}×", None
        return f"{aim.least:g}×", row["ratio"] >= aim.least
    return "", None


def ratio_text(row):
    if "ratio" not in row:
        return ""
    return f"{row['ratio']:.2f} ({row['low']:.2f} to {row['high']:.2f})"


def rows_of(result):
    case = next(case for case in CASES if case.name == result["case"])
    for figure, row in result["figures"].items():
        what, unit, _, _ = FIGURES[figure]
        aim, reached = verdict(case, figure, row)
        yield (f"{what}, {unit}" if unit else what, number(row["ours"], figure),
               number(row["theirs"], figure) if "theirs" in row else "", ratio_text(row), aim,
               {True: "reached", False: "**not reached**", None: ""}[reached])


def text(result):
    lines = [f"{result['case']}: {result['runs']} runs in turn, {result['threads']} threads"]
    for what, ours, theirs, ratio, aim, reached in rows_of(result):
        lines.append(f"  {what:42} {ours:>14} {theirs:>14}  {ratio:24} {aim:18} {reached.strip('*')}")
    if result.get("means"):
        lines.append(f"  means: {result['means'][0]:.6g} {result['means'][1]:.6g}")
    lines += [f"  {note}" for note in result.get("notes", [])]
    return "\n".join(lines)


def commit():
    done = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    return done.stdout.strip() or "unknown"


def markdown(results):
    """Of results in the order of the cases."""
    lines = ["| case | | scnrender | peer | ratio (spread) | aim | |", "|---|---|---|---|---|---|---|"]
    notes = []
    for case in CASES:
        result = results.get(case.name)
        if not result:
            lines.append(f"| {case.name} | not measured | | | | | |")
            continue
        for row, (what, ours, theirs, ratio, aim, reached) in enumerate(rows_of(result)):
            name = f"**{case.name}** ({PEERS[case.peer]})" if row == 0 else ""
            lines.append(f"| {name} | {what} | {ours} | {theirs} | {ratio} | {aim} | {reached} |")
        note = f"- {case.name}: {case.what}; {result['runs']} runs, {result['threads']} threads, at " \
               f"commit {result['commit']}, with {result['load']:.0f} jobs waiting for " \
               f"{os.cpu_count()} processors."
        if result.get("means"):
            difference = 100 * (result["means"][1] / result["means"][0] - 1)
            note += f" Mean luminance there against here: {difference:+.2f} %."
        notes.append(" ".join([note, *result.get("notes", [])]))
    return "\n".join([*lines, "", *notes])


def write(results):
    with open(PAGE, encoding="utf-8") as file:
        page = file.read()
    start = page.index("\n", page.index(BEGIN)) + 1
    page = page[:start] + "\n" + markdown(results) + "\n\n" + page[page.index(END):]
    with open(PAGE + ".new", "w", encoding="utf-8") as file:
        file.write(page)
    os.replace(PAGE + ".new", PAGE)

"""Prints results, as text and as the Markdown table of docs/performance.md."""
import os
import subprocess

from .cases import CASES, ROOT
from .measure import FIGURES

REACHED = {True: "reached", False: "**not reached**", None: ""}
PEERS = {"povray": "POV-Ray 3.7", "cycles": "Cycles"}
BEGIN, END = "<!-- tools/bench --write: from here", "<!-- to here -->"
PAGE = os.path.join(ROOT, "docs/performance.md")


def plural(count, word):
    return f"{count} {word}{'' if count == 1 else 's'}"


def number(value, figure):
    digits = FIGURES[figure][2]
    if digits == 9:
        return f"{value:.2e}"
    return f"{value:,.{digits}f}"


def wanted(aim):
    unit = FIGURES[aim.figure][1].split(" ")[0]
    if aim.absolute:
        return f"{'at least' if FIGURES[aim.figure][3] else 'at most'} {aim.least:g} {unit}"
    return f"{aim.least:g}×"


def reached(aim, row):
    if aim.absolute:
        more = FIGURES[aim.figure][3]
        return row["ours"] >= aim.least if more else row["ours"] <= aim.least
    return row["ratio"] >= aim.least if "ratio" in row else None


def ratio_text(row):
    if "ratio" not in row:
        return ""
    return f"{row['ratio']:.2f} ({row['low']:.2f} to {row['high']:.2f})"


def rows_of(result):
    case = next(case for case in CASES if case.name == result["case"])
    for figure, row in result["figures"].items():
        what, unit, _, _ = FIGURES[figure]
        aim = next((aim for aim in case.aims if aim.figure == figure), None)
        yield (f"{what}, {unit}" if unit else what, number(row["ours"], figure),
               number(row["theirs"], figure) if "theirs" in row else "", ratio_text(row),
               wanted(aim) if aim else "", REACHED[reached(aim, row) if aim else None])


def text(result):
    lines = [f"{result['case']}: {plural(result['runs'], 'run')} in turn, {result['threads']} threads"]
    for what, ours, theirs, ratio, aim, end in rows_of(result):
        lines.append(f"  {what:42} {ours:>14} {theirs:>14}  {ratio:24} {aim:18} {end.strip('*')}")
    if result.get("means"):
        lines.append(f"  means: {result['means'][0]:.6g} {result['means'][1]:.6g}")
    lines += [f"  {note}" for note in result.get("notes", [])]
    return "\n".join(lines)


def commit():
    done = subprocess.run(["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True,
                          text=True, check=False)
    return done.stdout.strip() or "unknown"


def aims(results):
    """A line for each aim."""
    lines = ["| case | | aim | measured | |", "|---|---|---|---|---|"]
    for case in CASES:
        figures = results.get(case.name, {}).get("figures", {})
        for aim in case.aims:
            what, unit, _, _ = FIGURES[aim.figure]
            measured, end = "not measured", ""
            row = figures.get(aim.figure)
            if row and aim.absolute:
                measured = f"{number(row['ours'], aim.figure)} {unit.split(' ')[0]}"
            elif row and "ratio" in row:
                measured = f"{row['ratio']:.1f}×"
            if row:
                end = REACHED[reached(aim, row)]
            lines.append(f"| {case.name} | {what} | {wanted(aim)} | {measured} | {end} |")
    return lines


def markdown(results):
    """Of results in the order of the cases."""
    lines = [*aims(results), "", "All figures:", "",
             "| case | | scnrender | peer | ratio (spread) | aim | |", "|---|---|---|---|---|---|---|"]
    notes = []
    for case in CASES:
        result = results.get(case.name)
        if not result:
            lines.append(f"| {case.name} | not measured | | | | | |")
            continue
        for row, (what, ours, theirs, ratio, aim, end) in enumerate(rows_of(result)):
            name = f"**{case.name}** ({PEERS[case.peer]})" if row == 0 else ""
            lines.append(f"| {name} | {what} | {ours} | {theirs} | {ratio} | {aim} | {end} |")
        note = f"- {case.name}: {case.what}; {plural(result['runs'], 'run')}, {result['threads']} threads, at " \
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

"""report/index.html: opens from disk, asks for nothing but the pictures beside it."""
import html
import json
import os
import shutil

from tool import verdict
from tool.run import PROGRAMS

HERE = os.path.dirname(os.path.abspath(__file__))
MAPS = (("relative", "relative error", "0.01 % black, 0.1 % purple, 1 % red, 10 % orange, 100 % pale; turquoise: on a silhouette"),
        ("difference", "difference", "red: brighter there; blue: brighter here; full color: 10 % of white"),
        ("flip", "ꟻLIP", "what an eye sees when the pictures alternate: 0 black, 1 pale"))
MOST_ROWS = 40


def escape(text):
    return html.escape(str(text), quote=True)


def number(value, digits=5):
    if value is None:
        return "—"
    if value == 0:
        return "0"
    return f"{value:.{digits}g}"


def percent(value, digits=3):
    return "—" if value is None else f"{100 * value:.{digits}f} %"


def state_of(part):
    if part["must_agree"] is None:
        return "free", "not asked to agree"
    return ("wrong", "differs") if part["wrong"] else ("right", "agrees")


def must_text(partner, part):
    if part["must_agree"] is None:
        return "Need not agree."
    if partner == "povray" and not part["must_agree"]:
        return f"Must agree: {verdict.LEAST_PERCENT} % of the pixels within 0.1 %."
    names = ", ".join(part["must_agree"]) or "the whole picture"
    return (f"Must agree: the mean radiance of {names}, within {100 * verdict.RATIO_TOLERANCE:g} % and "
            f"{verdict.LARGEST_Z} standard errors.")


# --- One scene -----------------------------------------------------------------------------------


def figure(source, caption, size):
    return (f'<figure><img src="{escape(source)}" alt="{escape(caption)}" width="{size[0]}" '
            f'height="{size[1]}" loading="lazy"><figcaption>{escape(caption)}</figcaption></figure>')


def pictures_of(result):
    """[(program, file, caption)]: ours and each partner's, under one exposure."""
    any_partner = next(iter(result["partners"]))
    out = [("scnrender", f"{result['name']}/{any_partner}_ours.png")]
    out += [(partner, f"{result['name']}/{partner}_theirs.png") for partner in result["partners"]]
    return [(program, file, f"{PROGRAMS[program]}, {result['seconds'][program]:.2f} s")
            for program, file in out]


def wipe(result, pictures):
    choices = [f'<option value="{escape(file)}">{escape(PROGRAMS[program])}</option>'
               for program, file, _ in pictures]
    second = [choice.replace("<option", "<option selected", 1) if i == 1 else choice
              for i, choice in enumerate(choices)]
    width, height = result["size"]
    name = escape(result["name"])
    return f'''<div class="wipe" data-scene="{name}">
<div class="stage" style="aspect-ratio: {width} / {height}">
<img class="under" src="{escape(pictures[1][1])}" alt="right of the slider" width="{width}" height="{height}">
<img class="over" src="{escape(pictures[0][1])}" alt="left of the slider" width="{width}" height="{height}">
<div class="bar"></div></div>
<div class="controls"><label>left <select class="left">{"".join(choices)}</select></label>
<input type="range" min="0" max="100" value="50" step="0.1" aria-label="where the pictures meet">
<label>right <select class="right">{"".join(second)}</select></label></div></div>'''


def region_table(partner, part):
    must = part["must_agree"] or []
    rows = part["rows"]
    order = {"(picture)": 0, "(edges)": 2, "(others)": 2, "(background)": 2}
    rows = sorted(rows, key=lambda row: (order.get(row["name"], 1), row["name"] not in must,
                                         -row["pixels"]))
    lines = []
    for row in rows[:MOST_ROWS]:
        asked = row["name"] in must or ("picture" in must and row["name"] == "(picture)") or \
            (partner == "cycles" and part["must_agree"] == [] and row["name"] == "(picture)")
        fault = verdict.judge_region(row) if asked else None
        kind = "wrong" if fault else "right" if asked else ""
        reason = fault or part["differs"].get(row["name"], "")
        z = "—" if row["z"] is None else f"{row['z']:+.2f}"
        ratio = "—" if row["ratio"] is None else f"{row['ratio']:.5f}"
        lines.append(
            f'<tr class="{kind}"><th scope="row">{escape(row["name"])}</th><td>{row["pixels"]}</td>'
            f'<td>{number(row["ours"])}</td><td>{number(row["theirs"])}</td><td>{ratio}</td>'
            f'<td>{percent(row["error"])}</td><td>{z}</td><td class="why">{escape(reason)}</td></tr>')
    rest = len(rows) - MOST_ROWS
    if rest > 0:
        lines.append(f'<tr><td colspan="8">and {rest} more</td></tr>')
    name = escape(PROGRAMS[partner])
    return f'''<div class="scroll"><table class="regions"><caption>Mean radiance, object by object</caption>
<thead><tr><th>region</th><th>pixels</th><th>scnrender</th><th>{name}</th><th>ratio</th><th>±</th><th>z</th>
<th></th></tr></thead><tbody>{"".join(lines)}</tbody></table></div>'''


def notes_list(part):
    if not part["notes"]:
        return '<p class="notes">All of the scene has an exact partner.</p>'
    items = [f"<li><code>{escape(note['place'])}</code> {escape('; '.join(note['texts']))}</li>"
             for note in part["notes"]]
    return (f'<details class="notes"><summary>{len(items)} without an exact partner</summary>'
            f'<ul>{"".join(items)}</ul></details>')


def partner_block(result, partner, part):
    kind, word = state_of(part)
    agree, oiio = part["agree"], part["oiio"]
    reasons = "".join(f"<li>{escape(text)}</li>" for text in part["wrong"])
    reasons += "".join(f"<li><b>{escape(name or 'differs')}</b>: {escape(text)}</li>"
                       for name, text in part["differs"].items())
    figures = (f"{agree['percent']:.2f} % of the pixels within 0.1 %; of the others "
               f"{agree['differ_on_silhouettes']} lie on silhouettes, {agree['differ_elsewhere']} "
               f"elsewhere. RMS error {number(oiio.get('rms', 0), 3)}, largest "
               f"{number(oiio.get('max', 0), 3)}. Mean ꟻLIP {part['flip']:.4f}.")
    maps = "".join(figure(f"{result['name']}/{partner}_{name}.png", f"{title} ({legend})",
                          result["size"]) for name, title, legend in MAPS)
    return f'''<section class="partner"><h3>{escape(PROGRAMS[partner])} <span class="badge {kind}">{word}</span></h3>
<p>{escape(must_text(partner, part))} {escape(figures)}</p>
{f'<ul class="reasons">{reasons}</ul>' if reasons else ''}
<div class="maps">{maps}</div>
{region_table(partner, part)}{notes_list(part)}</section>'''


def scene_block(result):
    pictures = pictures_of(result)
    side = "".join(figure(file, caption, result["size"]) for _, file, caption in pictures)
    blocks = "".join(partner_block(result, partner, part)
                     for partner, part in result["partners"].items())
    seeds = "no noise" if result["seeds"] == 1 else \
        f"{result['seeds']} seeds of {result['samples']} samples here"
    return f'''<article id="{escape(result['name'])}"><h2>{escape(result['name'])}</h2>
<p class="title">{escape(result['title'])}</p>
<p class="small"><code>{escape(result['path'])}</code>, {result['size'][0]} × {result['size'][1]}, {seeds};
the pictures are under one exposure, of which white is {number(1 / white(result), 3)}.</p>
<div class="side">{side}</div>{wipe(result, pictures)}{blocks}</article>'''


def white(result):
    return next(iter(result["partners"].values()))["exposure"]


# --- The page ------------------------------------------------------------------------------------


def summary_row(result):
    cells = []
    for partner in ("povray", "cycles"):
        part = result["partners"].get(partner)
        if not part:
            cells.append("<td>—</td><td></td>")
            continue
        kind, word = state_of(part)
        if partner == "povray":
            value = f"{part['agree']['percent']:.2f} %"
        else:
            row = next(row for row in part["rows"] if row["name"] == "(picture)")
            value = "—" if row["ratio"] is None else f"{row['ratio']:.5f} ± {row['error']:.5f}"
        cells.append(f'<td><span class="badge {kind}">{word}</span></td><td>{value}</td>')
    times = " / ".join(f"{result['seconds'][name]:.1f}" if name in result["seconds"] else "—"
                       for name in ("scnrender", "povray", "cycles"))
    return (f'<tr><th scope="row"><a href="#{escape(result["name"])}">{escape(result["name"])}</a></th>'
            f'{"".join(cells)}<td>{times}</td></tr>')


def page(results, versions):
    wrong = sum(bool(part["wrong"]) for result in results for part in result["partners"].values())
    asked = sum(part["must_agree"] is not None for result in results
                for part in result["partners"].values())
    word = f"{asked - wrong} of {asked} that must agree do."
    with open(os.path.join(HERE, "report.css"), encoding="utf-8") as file:
        style = file.read()
    with open(os.path.join(HERE, "report.js"), encoding="utf-8") as file:
        script = file.read()
    programs = "; ".join(escape(text) for text in versions.values())
    return f'''<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>scnrender beside POV-Ray and Cycles</title><link rel="icon" href="data:,">
<style>{style}</style></head><body>
<header><h1>scnrender beside POV-Ray and Cycles</h1>
<p class="verdict {'wrong' if wrong else 'right'}" id="verdict">{escape(word)}</p><p class="small">{programs}</p></header>
<main><div class="scroll"><table class="summary"><thead><tr><th>scene</th><th colspan="2">POV-Ray: pixels within 0.1 %</th>
<th colspan="2">Cycles: ratio of the picture's mean, theirs over ours</th><th>seconds, here / POV-Ray / Cycles</th></tr></thead>
<tbody>{"".join(map(summary_row, results))}</tbody></table></div>
{"".join(map(scene_block, results))}</main>
<script>{script}</script></body></html>
'''


def write(folder, results, versions):
    """Its path. The figures lie beside it as report.json."""
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "report.json"), "w", encoding="utf-8") as file:
        json.dump({"version": 1, "programs": versions, "scenes": results}, file, indent=1)
    index = os.path.join(folder, "index.html")
    with open(index + ".new", "w", encoding="utf-8") as file:
        file.write(page(results, versions))
    shutil.move(index + ".new", index)
    return index

"""From figures to a verdict, and against the figures kept."""
import math

from tool.scene import plural

RATIO_TOLERANCE = 0.005  # of a region's mean radiance
LARGEST_Z = 4
LEAST_PERCENT = 99.5  # of the pixels within 0.1 %, for POV-Ray
# The export's own errors, flat pieces and single precision, are of this size: a smaller difference may be
# ever so certain.
EXPORT_TOLERANCE = 0.0005
MOST_ERROR = RATIO_TOLERANCE / 2  # a noisier ratio says nothing


def region_row(region):
    """The ratio of mean radiances, theirs over ours, with its standard error and the z-score."""
    a, b = region["ours"], region["theirs"]
    row = {"name": region["name"], "pixels": region["pixels"], "ours": a["mean"],
           "theirs": b["mean"], "ours_error": a["error"], "theirs_error": b["error"],
           "ours_rgb": a["rgb"], "theirs_rgb": b["rgb"]}
    noise = math.hypot(a["error"], b["error"])
    row["z"] = (b["mean"] - a["mean"]) / noise if noise > 0 else None
    if a["mean"] > 0 and b["mean"] > 0:
        row["ratio"] = b["mean"] / a["mean"]
        row["error"] = row["ratio"] * math.hypot(a["error"] / a["mean"], b["error"] / b["mean"])
    else:
        row["ratio"] = 1.0 if a["mean"] == b["mean"] else None
        row["error"] = 0.0
    return row


def rows_of(figures):
    return [region_row(region) for region in figures["regions"]]


def judge_region(row):
    """None, or what is wrong."""
    if row["ratio"] is None:
        return "one side is black"
    if row["error"] > MOST_ERROR:
        return f"too noisy: known to {100 * row['error']:.2f} % only"
    if abs(row["ratio"] - 1) > RATIO_TOLERANCE:
        return f"the means differ by {100 * (row['ratio'] - 1):+.2f} %"
    # Without noise on either side the ratio alone counts.
    certain = row["z"] is not None and abs(row["z"]) > LARGEST_Z
    if certain and abs(row["ratio"] - 1) > EXPORT_TOLERANCE:
        return f"the means are {abs(row['z']):.1f} standard errors apart"
    return None


def judge(wish, partner, figures):
    """What is wrong, a line each; empty where all that must agree does."""
    if wish.agrees is None:
        return []
    if partner == "povray" and not wish.agrees:
        percent = figures["agree"]["percent"]
        if percent >= LEAST_PERCENT:
            return []
        return [f"{percent:.2f} % of the pixels agree, not {LEAST_PERCENT} %"]
    rows = {row["name"]: row for row in rows_of(figures)}
    wrong = []
    for name in wish.agrees or ["(picture)"]:
        if name == "picture":
            name = "(picture)"
        if name not in rows:
            wrong.append(f"{name}: not to be seen")
            continue
        fault = judge_region(rows[name])
        if fault:
            wrong.append(f"{name}: {fault}")
    return wrong


# --- Figures that are kept -----------------------------------------------------------------------


def figures_to_keep(results):
    """{scene: {partner: {"percent": …, "regions": {name: [ratio, error]}}}}; regions called by their line
    are left out, since lines move."""
    kept = {}
    for result in results:
        kept[result["name"]] = {
            partner: {
                "percent": round(part["agree"]["percent"], 4),
                "regions": {row["name"]: [round(row["ratio"], 7), round(row["error"], 7)]
                            for row in part["rows"]
                            if row["ratio"] is not None and ".scn:" not in row["name"]}}
            for partner, part in result["partners"].items()}
    return kept


def moved(kept, results):
    """Ratios that moved by more than their error since they were kept, a line each."""
    lines = []
    now = figures_to_keep(results)
    for scene, partners in now.items():
        if scene not in kept:
            lines.append(f"{scene}: no figures are kept")
            continue
        for partner, part in partners.items():
            before = kept[scene].get(partner)
            if not before:
                lines.append(f"{scene}, {partner}: no figures are kept")
                continue
            # Where noise lies between them, it moves the share, too.
            noiseless = before["percent"] >= LEAST_PERCENT
            if noiseless and part["percent"] < before["percent"] - 0.05:
                lines.append(f"{scene}, {partner}: {part['percent']:.2f} % of the pixels agree, "
                             f"{before['percent']:.2f} % did")
            lines += moved_regions(f"{scene}, {partner}", before["regions"], part["regions"])
    return lines


def moved_regions(where, before, now):
    lines = []
    for name in sorted(set(before) | set(now)):
        if name not in now or name not in before:
            lines.append(f"{where}, {name}: {'gone' if name not in now else 'new'}")
            continue
        (old, old_error), (new, new_error) = before[name], now[name]
        # Without noise, rounding is what is left.
        allowed = LARGEST_Z * math.hypot(old_error, new_error) + 2e-5
        if abs(new - old) > allowed:
            lines.append(f"{where}, {name}: the ratio was {old:.5f} and is {new:.5f} "
                         f"(+- {allowed:.5f})")
    return lines


def kept_summary(kept, scenes):
    """What the kept figures say of those scenes that must agree, {partner: line}."""
    pixels, ratios, of = [], [], {"povray": 0, "cycles": 0}
    for scene in scenes:
        for partner, wish in scene.wishes.items():
            part = kept.get(scene.name, {}).get(partner)
            if wish.agrees is None or part is None:
                continue
            of[partner] += 1
            if partner == "povray" and not wish.agrees:
                pixels.append(part["percent"])
                continue
            for name in wish.agrees or ["(picture)"]:
                ratios.append(part["regions"]["(picture)" if name == "picture" else name][0])
    off = math.sqrt(sum((ratio - 1) ** 2 for ratio in ratios) / max(len(ratios), 1))
    return {
        "povray": f"{plural(of['povray'], 'scene')}: {min(pixels, default=0):.2f} % to {max(pixels, default=0):.2f} % "
                  "of the pixels are within 0.1 %",
        "cycles": f"{plural(of['cycles'], 'scene')}, {plural(len(ratios), 'region')}: mean radiance {min(ratios, default=0):.4f} to "
                  f"{max(ratios, default=0):.4f} of ours, {100 * off:.2f} % off (root mean square)"}

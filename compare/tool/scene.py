"""What a scene says of its comparison, in comments that begin with `//@`:

    //@ povray agrees
    //@ cycles agrees: floor, ball
    //@ cycles differs: rim: the reason
    //@ povray differs: the reason, where no pixel need agree
    //@ samples: 256            here, for each seed
    //@ cycles samples: 256     there

`//@` and two spaces or more continue the line before.
`povray agrees` means 99.5 % of the pixels within 0.1 %; `cycles agrees` the mean radiance of each named
region within 0.5 %, at most four standard errors apart.
"""
import os
import re

PARTNERS = ("povray", "cycles")


class SceneError(Exception):
    """A directive that can't be understood."""


class Wish:
    """What is asked of one partner."""

    def __init__(self):
        self.agrees = None  # None: nothing; []: the whole picture; else names of regions
        self.differs = {}  # region ("": everything): reason


class Directives:
    def __init__(self, path):
        self.path = path
        self.name = os.path.splitext(os.path.basename(path))[0]
        self.wishes = {partner: Wish() for partner in PARTNERS}
        self.samples = {"scnrender": None, "cycles": None}
        self.title = ""
        with open(path, encoding="utf-8") as file:
            self._read(file.read().splitlines())

    def _read(self, lines):
        directives, intro = [], []
        for number, line in enumerate(lines, 1):
            line = line.strip()
            if line.startswith("//@"):
                text = line[3:]
                if text.startswith("  ") and directives:
                    directives[-1][1] += " " + text.strip()
                else:
                    directives.append([number, text.strip()])
            elif line.startswith("//") and not directives and len(intro) == number - 1:
                intro.append(line[2:].strip())
        self.title = " ".join(intro)
        for number, text in directives:
            if not self._take(text):
                raise SceneError(f"{self.path}:{number}: `{text}` is no directive")

    def _take(self, text):
        match = re.fullmatch(r"(?:(scnrender|cycles) )?samples: *(\d+)", text)
        if match:
            self.samples[match[1] or "scnrender"] = int(match[2])
            return True
        match = re.fullmatch(r"(povray|cycles) agrees(?:: *(.+))?", text)
        if match:
            regions = [name.strip() for name in match[2].split(",")] if match[2] else []
            self.wishes[match[1]].agrees = regions
            return True
        match = re.fullmatch(r"(povray|cycles) differs: *(?:([^:]+): +)?(.+)", text)
        if match:
            for name in (match[2] or "").split(","):
                self.wishes[match[1]].differs[name.strip()] = match[3]
            return True
        return False


def plural(count, word):
    return f"{count} {word}{'' if count == 1 else 's'}"

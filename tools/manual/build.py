"""The manual as static HTML: the README and docs/*.md through cmark-gfm, with the pictures and scenes that they name.

Usage: build.py DIR.  Exit status 1 where a link leads nowhere."""
import html
import os
import re
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))

# The order of the side bar; pages that aren't named follow by name.
ORDER = ["README.md", "docs/tutorial.md", "docs/language.md", "docs/reference.md", "docs/light.md", "docs/watch.md", "docs/batch.md",
         "docs/editors.md", "docs/testing.md", "docs/from_povray.md", "docs/from_blender.md", "docs/trust.md",
         "docs/agreement.md", "docs/performance.md"]


def pages():
    found = ["README.md"] + sorted("docs/" + f for f in os.listdir(os.path.join(ROOT, "docs")) if f.endswith(".md"))
    return sorted(found, key=lambda p: (ORDER.index(p) if p in ORDER else len(ORDER), p))


def target_of(page):
    return "index.html" if page == "README.md" else page[:-3] + ".html"


def anchor(text):
    """The name of a heading, as GitHub makes it."""
    text = re.sub(r"<[^>]*>", "", text)
    text = html.unescape(text).strip().lower()
    return re.sub(r"[^\w\- ]", "", text).replace(" ", "-")


def with_anchors(body):
    seen = {}

    def heading(match):
        name = anchor(match.group(2))
        again = seen.get(name, 0)
        seen[name] = again + 1
        name = f"{name}-{again}" if again else name
        level = match.group(1)
        return f'<h{level} id="{name}">{match.group(2)}<a class="here" href="#{name}" aria-label="link to this">#</a></h{level}>'

    return re.sub(r"<h([1-6])>(.*?)</h\1>", heading, body, flags=re.S)


# --- Colors of the language --------------------------------------------------------------------

TOKEN = re.compile(r"""(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<string>"(?:[^"\\\n]|\\.)*")|(?P<color>\#[0-9a-fA-F]{3,6}\b)
  |(?P<number>\b\d[\d_]*(?:\.\d+)?(?:[eE][+-]?\d+)?[A-Za-z]*)
  |(?P<word>\b(?:scn|import|as|param|let|fn|for|in|if|else|true|false|with|and|or|not|expect)\b)
  |(?P<kind>\b[a-z_]\w*(?=\s*\{))|(?P<field>\b[a-z_]\w*(?=:))""", re.S | re.X)


def colored(code):
    text, out, at = html.unescape(code), [], 0
    for match in TOKEN.finditer(text):
        out.append(html.escape(text[at:match.start()], quote=False))
        out.append(f'<span class="{match.lastgroup}">{html.escape(match.group(), quote=False)}</span>')
        at = match.end()
    return "".join(out) + html.escape(text[at:], quote=False)


def with_colors(body):
    return re.sub(r'<pre><code class="language-scn">(.*?)</code></pre>',
                  lambda m: f'<pre><code class="language-scn">{colored(m.group(1))}</code></pre>', body, flags=re.S)


# --- Pages --------------------------------------------------------------------------------------

def title_of(body):
    match = re.search(r"<h1[^>]*>(.*?)<", body, flags=re.S)
    return html.unescape(re.sub(r"<[^>]*>", "", match.group(1))).strip() if match else "scnrender"


def render(page):
    with open(os.path.join(ROOT, page), encoding="utf-8") as file:
        text = file.read()
    body = subprocess.run(["cmark-gfm", "-e", "table", "-e", "autolink", "-e", "strikethrough"], input=text,
                          capture_output=True, encoding="utf-8", check=True).stdout
    return with_colors(with_anchors(body))


LINK = re.compile(r'\b(href|src)="([^"]*)"')


def links(body):
    for match in LINK.finditer(body):
        where = html.unescape(match.group(2))
        if not re.match(r"[a-z]+:", where):
            yield where


def relink(page, body):
    """Links to pages lead to their HTML."""
    known = {p: target_of(p) for p in pages()}
    folder = os.path.dirname(page)

    def link(match):
        where, _, part = html.unescape(match.group(2)).partition("#")
        there = os.path.normpath(os.path.join(folder, where)) if where else page
        if where and there in known:
            where = os.path.relpath(known[there], os.path.dirname(target_of(page)) or ".")
        return f'{match.group(1)}="{html.escape(where + ("#" + part if part else ""))}"'

    return LINK.sub(link, body)


def side_bar(page, titles):
    items = []
    for other, title in titles.items():
        where = os.path.relpath(target_of(other), os.path.dirname(target_of(page)) or ".")
        here = ' aria-current="page"' if other == page else ""
        items.append(f'<li><a href="{where}"{here}>{html.escape(title)}</a></li>')
    return "<nav><ul>" + "".join(items) + "</ul></nav>"


def copy_named(page, body, out, problems):
    """Copies the files of the repository that the page names."""
    for where in links(body):
        path = where.partition("#")[0]
        there = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
        source, goal = os.path.join(ROOT, there), os.path.join(out, there)
        if there in pages() or not path:
            continue
        if there.startswith(".."):
            problems.append(f"{page}: {where} leads out of the repository")
        elif os.path.isfile(source):
            os.makedirs(os.path.dirname(goal), exist_ok=True)
            shutil.copyfile(source, goal)
        elif os.path.isdir(source):
            shutil.copytree(source, goal, dirs_exist_ok=True)
        else:
            problems.append(f"{page}: {where} is not there")


def check_links(out, page, body, problems):
    file = target_of(page)
    for where in links(body):
        path, _, part = where.partition("#")
        there = os.path.normpath(os.path.join(os.path.dirname(file), path)) if path else file
        goal = os.path.join(out, there)
        if not os.path.exists(goal):
            problems.append(f"{page}: {where} leads nowhere")
        elif part and there.endswith(".html"):
            with open(goal, encoding="utf-8") as other:
                if f'id="{part}"' not in other.read():
                    problems.append(f"{page}: {where} has no such place")


def main(out):
    with open(os.path.join(HERE, "page.html"), encoding="utf-8") as file:
        template = file.read()
    shutil.rmtree(out, ignore_errors=True)
    os.makedirs(out)
    bodies = {page: render(page) for page in pages()}
    titles = {page: title_of(body) for page, body in bodies.items()}
    problems, made = [], {}
    for page, body in bodies.items():
        copy_named(page, body, out, problems)
        made[page] = (template.replace("{{title}}", html.escape(titles[page])).replace("{{nav}}", side_bar(page, titles))
                      .replace("{{body}}", relink(page, body)))
        goal = os.path.join(out, target_of(page))
        os.makedirs(os.path.dirname(goal) or ".", exist_ok=True)
        with open(goal, "w", encoding="utf-8") as file:
            file.write(made[page])
    for page, text in made.items():
        check_links(out, page, text, problems)
    for problem in problems:
        print(problem, file=sys.stderr)
    print(f"{out}: {len(made)} pages, {'every link leads somewhere' if not problems else f'{len(problems)} broken links'}")
    return 1 if problems else 0


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1]))

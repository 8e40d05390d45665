# SPDX-License-Identifier: Apache-2.0
"""Checks what people read: check_words.py ROOT [PROGRAM] [--long N].

Six rules. Each fault is a line `FILE[:LINE]: what is wrong`; with any the exit code is 1.

1. Sentences. The mean over README.md and the pages of docs is at most 15 words a sentence. The mean of each
   file is printed; docs/experiments is not counted. What counts is prose. Left out are tables, headings,
   comments, lines of pictures and code blocks (fenced, or indented by four columns after an empty line).
   Lines that follow each other are one paragraph; each item of a list is a paragraph of its own. A sentence
   ends at the end of its paragraph, or at a word that ends in . ! or ? (quotes, brackets and emphasis may
   close behind it), unless the word is an abbreviation. A colon or semicolon ends none. A word is what stands
   between spaces and holds a letter or a digit. Code between back quotes is one word. Of a link only its text
   counts.
2. Links. A relative link names a file that is there; what follows # is a heading of it, as GitHub spells it.
3. Names. A name between back quotes that looks like a file of the repository is one. It looks so if it ends
   as a source file does, or has a slash behind a folder at the top or a layer of src. It is found if a file
   or folder ends with it, with or without the file's ending: `core/parallel` is src/core/parallel.cpp, and
   `train/discard` is tests/train/discard_test.cpp. Stars and {a,b} stand for what they do in a shell. What
   runs and CMake write is listed below.
4. Commands. Options of `splinevox VERB --option` are in `PROGRAM VERB --help`. So are those of
   `VERB --option` alone between back quotes. Code blocks count. Without PROGRAM this rule is not asked.
5. Columns. No line of a source file is longer than 110.
6. Private words. Sources below src and include use the field's words (docs/glossary.md). PRIVATE_WORDS lists
   phrases that stood for them once, in comments, texts and names of types. Only these phrases are found; a
   word alone, as in "the rest" or "it is told", is ordinary English. Keys such as held_psnr are no phrases.

`--long N` also lists every sentence of more than N words.
"""
import argparse
import fnmatch
import os
import re
import shlex
import subprocess
import sys

MOST_WORDS = 15
MOST_COLUMNS = 110
SOURCE_ENDINGS = (".cpp", ".hpp", ".cu", ".cuh", ".cmake", ".py", ".sh", ".js", ".css", ".html", ".frag",
                  ".vert")
SOURCE_NAMES = ("CMakeLists.txt", "dev")
NOT_READ = ("build*", "out", "demo", "shared", ".git", ".ccache", "__pycache__")
SHELLS = ("sh", "bash", "console")
LAYERS = ("core", "math", "data", "field", "render", "backend", "train", "io", "run", "view", "report", "cli",
          "python")
TOP_FOLDERS = ("bench", "cmake", "data_scripts", "docs", "include", "src", "tests")
WRITTEN_BY_RUNS = ("array.sh", "page.html", "report.html", "view.html", "table.md", "cost.md", "torture.md")
WRITTEN_BY_CMAKE = ("splinevox/core/version.hpp",)
SPOKEN = ("src", "include")
PRIVATE_WORDS = (
    (r"held[- ]back|held (?:view|picture|frame)s?", "held-out"),
    (r"(?:ray|picture|view|fit)s? (?:ha[sd] |have )?(?:never )?(?:shown|seen)", "visible"),
    (r"seen by (?:a |the |any |no )?(?:ray|picture|fit)s?|(?:struct|class) (?:Seen|Shown)\w*", "visible"),
    (r"(?:come|came|told|allowed) to rest|comes to rest|lets? \w+ rest", "static, or frozen"),
    (r"awake|asleep", "active, or frozen"),
    (r"still (?:scene|model)s?", "static"),
    (r"bricks? (?:go|goes|went)", "pruned"),
)
ABBREVIATIONS = ("e.g.", "i.e.", "cf.", "vs.", "al.", "Eq.", "Eqs.", "Fig.", "No.", "approx.", "ca.", "etc.")


# --- Markdown ---

def code_and_prose(text):
    """The lines of a page as (number, line, code), without the text of comments. Code is "" for prose, else
    the language of the fence, "sh" where none is named."""
    text = re.sub(r"<!--.*?-->", lambda m: "\n" * m.group().count("\n"), text, flags=re.S)
    fence, indented, blank_before = None, False, True
    for number, line in enumerate(text.split("\n"), 1):
        mark = re.match(r"\s*(```+|~~~+)\s*(\w*)", line)
        if fence:
            if mark and mark.group(1).startswith(fence):
                fence = None
            yield number, line, language
            continue
        if mark:
            fence, language = mark.group(1), mark.group(2) or "sh"
            yield number, "", language
            continue
        indented = line.startswith("    ") and (blank_before or indented) and line.strip() != ""
        yield number, line, "sh" if indented else ""
        blank_before = line.strip() == ""


def paragraphs(text):
    """Prose without tables, code, headings and lines of pictures, lines that belong together put together."""
    found = [""]
    for _, line, code in code_and_prose(text):
        line = re.sub(r"^\s*>\s?", "", line).strip()
        if code or not line or re.match(r"(\||#+ |!\[|---+$|===+$)", line):
            found.append("")
            continue
        item = re.match(r"([-*+]|\d+[.)])\s+", line)
        if item:
            found.append("")
            line = line[item.end():]
        found[-1] += " " + line
    return [p.strip() for p in found if p.strip()]


def sentences(text):
    """Every sentence of a page as a list of its words."""
    found = []
    for paragraph in paragraphs(text):
        paragraph = re.sub(r"``?[^`]+``?", lambda m: "code", paragraph)
        paragraph = re.sub(r"!?\[([^\]]*)\](\([^)]*\)|\[[^\]]*\])", r"\1", paragraph)
        words = []
        for word in paragraph.split():
            if re.search(r"\w", word):
                words.append(word)
            bare = word.strip("*_\"'()[]")
            if re.search(r"[.!?][\"')\]*_]*$", word) and bare not in ABBREVIATIONS:
                found.append(words)
                words = []
        found.append(words)
    return [words for words in found if words]


def headings(text):
    """The anchors of a page, as GitHub spells them."""
    found = []
    for _, line, code in code_and_prose(text):
        title = re.match(r"#+\s+(.*?)\s*#*$", line)
        if code or not title:
            continue
        plain = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", title.group(1)).replace("`", "").lower()
        slug = re.sub(r"[^\w\- ]", "", plain).replace(" ", "-")
        again = sum(re.fullmatch(re.escape(slug) + r"(-\d+)?", other) is not None for other in found)
        found.append(f"{slug}-{again}" if again else slug)
    return found + re.findall(r'<a (?:id|name)="([^"]+)"', text)


def code_spans(text):
    """(line, text) of what stands between back quotes outside of code blocks."""
    prose = "\n".join("" if code else line for _, line, code in code_and_prose(text))
    for m in re.finditer(r"(`+)(?!`)(.+?)(?<!`)\1(?!`)", prose, flags=re.S):
        yield prose.count("\n", 0, m.start()) + 1, " ".join(m.group(2).split())


# --- The rules ---

def link_faults(text, folder, exists, read):
    """Rule 2. @param folder  of the page. @param exists, read  say of a path from the root if it is and what.
    """
    prose = "\n".join("" if code else re.sub(r"`[^`]*`", "", line) for _, line, code in code_and_prose(text))
    for m in re.finditer(r"\]\(\s*<?([^)\s>]+)>?(?:\s+\"[^\"]*\")?\s*\)", prose):
        line, target = prose.count("\n", 0, m.start()) + 1, m.group(1)
        if re.match(r"[a-z][a-z+.-]*:", target):
            continue
        name, _, anchor = target.partition("#")
        path = os.path.normpath(os.path.join(folder, name)) if name else None
        if path and not exists(path):
            yield line, f"there is no '{target}'"
        elif not anchor or path and not path.endswith(".md"):
            continue
        elif anchor not in headings(read(path) if path else text):
            yield line, f"'{target}' has no such heading"


def expand(name):
    """{a,b} as a shell expands it."""
    m = re.search(r"\{([^{}]*,[^{}]*)\}", name)
    if not m:
        return [name]
    return [n for part in m.group(1).split(",") for n in expand(name[:m.start()] + part + name[m.end():])]


def looks_like_a_file(name):
    if not re.fullmatch(r"[\w.{}*,/+-]+", name) or name in WRITTEN_BY_RUNS + WRITTEN_BY_CMAKE:
        return False
    if name.endswith(SOURCE_ENDINGS + (".md",)) or os.path.basename(name) == "CMakeLists.txt":
        return not name.startswith(".")
    return "/" in name and name.split("/")[0] in TOP_FOLDERS + LAYERS


def name_faults(text, files):
    """Rule 3. @param files  of the repository, from its root."""
    known = set()
    for f in files:
        parts = f.split("/")
        stem = parts[-1].split(".")[0]
        known.update("/" + "/".join(parts[:n]) for n in range(1, len(parts)))
        for end in (parts[-1], parts[-1].removesuffix(".in"), stem, stem.removesuffix("_test")):
            known.add("/" + "/".join(parts[:-1] + [end]))
    for line, span in code_spans(text):
        name = re.sub(r":\d+$", "", span).rstrip("/")
        if not looks_like_a_file(name):
            continue
        for one in expand(name):
            if not any(fnmatch.fnmatchcase(k, "*/" + one) for k in known):
                yield line, f"there is no file '{one}'"


def commands(text):
    """(line, words, named) of what is said to splinevox. Named: its name stands before the words."""
    lines, begun = [], None
    for number, line, code in code_and_prose(text):
        if code in SHELLS:
            begun = (begun or "") + line.rstrip("\\")
            if not line.endswith("\\"):
                lines.append((number, begun, False))
                begun = None
    lines += [(number, span, True) for number, span in code_spans(text)]
    for number, line, is_span in lines:
        line = re.sub(r"(^|\s)#\s.*", "", line)
        line = re.sub(r"(?<=\w)\|(?=[\w.])", "/", line)  # bash|zsh is a choice and no pipe
        for place, part in enumerate(re.split(r"&&|;|\||>|\$\(", line)):
            try:
                words = shlex.split(part)
            except ValueError:
                words = part.split()
            at = next((i for i, w in enumerate(words) if w == "splinevox" or w.endswith("/splinevox")), None)
            if at is not None:
                yield number, words[at + 1:], True
            elif is_span and words and place == 0:
                yield number, words, False


def command_faults(text, options):
    """Rule 4. @param options  verb -> the options that its help has; "" -> those of the program itself."""
    for line, words, named in commands(text):
        verb = words[0] if words and re.fullmatch(r"[a-z]+", words[0]) else ""
        if verb not in options:
            if named:
                yield line, f"splinevox has no verb '{verb}'"
            continue
        if not verb and (not named or (words and re.match(r"[A-Z]", words[0]))):
            continue
        for word in words:
            option = re.match(r"--[a-z][a-z-]*", word)
            if option and option.group() not in options[verb]:
                yield line, f"splinevox {verb} has no option '{option.group()}'".replace("  ", " ")


def column_faults(text):
    """Rule 5."""
    for number, line in enumerate(text.split("\n"), 1):
        if len(line) > MOST_COLUMNS:
            yield number, f"{len(line)} columns; the limit is {MOST_COLUMNS}"


def private_faults(text):
    """Rule 6. A phrase may go on in the next line of a comment or a string."""
    for pattern, field in PRIVATE_WORDS:
        for m in re.finditer(r"\b(?:" + pattern.replace(" ", r"(?:\s|//+<?|\")+") + r")\b", text):
            words = " ".join(re.sub(r"//+<?|\"", " ", m.group()).split())
            yield text.count("\n", 0, m.start()) + 1, f"'{words}': the field says {field}"


# --- The repository ---

def all_files(root):
    found = []
    for folder, folders, names in os.walk(root):
        folders[:] = sorted(d for d in folders if not any(fnmatch.fnmatch(d, skip) for skip in NOT_READ))
        found += [os.path.relpath(os.path.join(folder, n), root) for n in sorted(names)]
    return found


def help_of(program):
    """verb -> its options, from what the program says of itself."""
    def asked(*words):
        return subprocess.run([program, *words, "--help"], check=True, capture_output=True, text=True).stdout

    def names(text):
        entries = re.findall(r"^  (?:-[a-z], )?(--[a-z][a-z-]*(?:, --[a-z][a-z-]*)*)", text, flags=re.M)
        return {name for entry in entries for name in entry.split(", ")}

    top = asked()
    verbs = re.findall(r"^  ([a-z]+)  ", top, flags=re.M)
    return {"": names(top) | {"--help", "--version"}, **{v: names(asked(v)) for v in verbs}}


def main():
    parser = argparse.ArgumentParser(description="Checks what people read.")
    parser.add_argument("root")
    parser.add_argument("program", nargs="?")
    parser.add_argument("--long", type=int, help="also list sentences of more words than this")
    args = parser.parse_args()
    files = all_files(args.root)

    def read(name):
        with open(os.path.join(args.root, name), encoding="utf-8") as f:
            return f.read()

    def exists(name):
        return os.path.exists(os.path.join(args.root, name))

    faults = []
    pages = [f for f in files if re.fullmatch(r"(docs/.*|[^/]*)\.md", f)]
    options = help_of(args.program) if args.program else None
    for page in pages:
        text = read(page)
        found = list(link_faults(text, os.path.dirname(page), exists, read)) + list(name_faults(text, files))
        found += command_faults(text, options) if options else []
        faults += [f"{page}:{line}: {what}" for line, what in sorted(found)]
    for f in files:
        if f.endswith(SOURCE_ENDINGS) or os.path.basename(f) in SOURCE_NAMES:
            faults += [f"{f}:{line}: {what}" for line, what in column_faults(read(f))]
        if f.endswith(SOURCE_ENDINGS) and f.split(os.sep)[0] in SPOKEN:
            faults += [f"{f}:{line}: {what}" for line, what in sorted(private_faults(read(f)))]

    words = count = 0
    for page in pages:
        cut = sentences(read(page))
        here = sum(map(len, cut))
        counted = page == "README.md" or re.match(r"docs/(?!experiments\b)", page)
        if counted:
            words, count = words + here, count + len(cut)
        note = "" if counted else " (not counted)"
        print(f"{here / max(1, len(cut)):5.1f} words a sentence in {len(cut):4d} sentences: {page}{note}")
        for s in sorted((s for s in cut if args.long and len(s) > args.long), key=len, reverse=True):
            print(f"      {len(s):3d}: {' '.join(s)}")
    mean = words / max(1, count)
    print(f"{mean:5.1f} words a sentence over all of them; the limit is {MOST_WORDS}")
    if mean > MOST_WORDS:
        faults.append(f"README.md, docs: {mean:.1f} words a sentence; --long 20 lists the long ones")
    print("\n".join(faults) if faults else "nothing to mend")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
